"""Depth of one camera in the pixels of another, and lenses in the five numbers that are used."""
