"""Track ahead from one keyframe, as far as the evidence carries."""
