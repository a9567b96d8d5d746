"""Recordings written without loss."""
