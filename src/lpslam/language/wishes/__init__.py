"""What a question means, as a form that a map can answer."""
