"""What a person says of landmarks: it wins over what was read."""
