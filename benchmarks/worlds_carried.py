"""Set down elsewhere in a world: blank frames, then another place of it, in the saved map."""
