"""Where frames come from: one file a format behind the `FrameSource` protocol."""
