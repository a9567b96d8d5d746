"""Trajectory, landmark and language scores."""
