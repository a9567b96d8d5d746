"""Following the camera: the pose of each frame against the map."""
