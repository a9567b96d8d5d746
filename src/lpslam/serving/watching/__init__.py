"""A map that is watched while it grows: the run feeds a process of its own, which serves the page."""
