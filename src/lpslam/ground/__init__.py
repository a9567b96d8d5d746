"""Ground to walk on: what keyframes saw of it, kept small, and the grid that follows from the map."""
