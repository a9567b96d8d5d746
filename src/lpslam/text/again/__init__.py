"""Second looks: texts whose name stayed unsure, read once more from all their views together."""
