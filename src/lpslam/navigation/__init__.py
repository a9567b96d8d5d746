"""Where, which and how: a wish answered by the places of a map."""
