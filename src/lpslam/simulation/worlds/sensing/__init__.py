"""What cameras and depth sensors make of a scene, by physics and published error models."""
