"""Files that hold many pictures: what is in them, and as a series."""
