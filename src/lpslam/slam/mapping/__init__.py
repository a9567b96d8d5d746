"""Local mapping: what happens to a keyframe after tracking."""
