"""Reading the scene's text and remembering it."""
