"""Parts of the body followed by what they look like (INITIAL §3.1), from one keyframe or both."""

from tracker.templates.given import LimbTracks, Start
from tracker.templates.tracks import limb_tracks

__all__ = ["LimbTracks", "Start", "limb_tracks"]
