"""Models behind an address: asked with patience, held to what they were given."""
