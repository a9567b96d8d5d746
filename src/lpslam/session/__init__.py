"""Making a map one frame at a time."""
