"""Cameras that are connected."""
