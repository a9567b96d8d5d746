"""Where to stand and how to go there, on the grid of the ground."""
