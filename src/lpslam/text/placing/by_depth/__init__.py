"""A text box and the depth image say where a text stands (paper, III-F)."""
