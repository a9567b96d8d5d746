"""How texts in a frame are read, and how well."""
