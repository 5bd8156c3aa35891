"""Follow parts of the body by templates (INITIAL §3.1), from one keyframe or both."""

from keypose.tracker.tracking.initial.templates.tracks import LimbTracks, Start, limb_tracks

__all__ = ["LimbTracks", "Start", "limb_tracks"]
