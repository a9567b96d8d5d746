"""Depth that is wrong by its range, found and corrected while running."""
