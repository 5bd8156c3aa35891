"""The body followed from one keyframe onward, as far as the evidence carries."""
