"""Review a tracked motion: what is wrong with it, where a keyframe helps, what to look at first."""
