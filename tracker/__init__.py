"""The method: from a video, a body and posed keyframes to a drift-corrected motion."""
