"""Uploads of recordings, each mapped in a process of its own."""
