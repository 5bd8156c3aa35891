"""Judge how far a motion can be trusted, and where a keyframe would help most."""
