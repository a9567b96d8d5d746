"""Many worlds: from one seed a camera, a motion, a place and a light; each is a `FrameSource`."""
