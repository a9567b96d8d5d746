"""A run watched while it goes: its frames, poses, words and points in files that viewers play."""
