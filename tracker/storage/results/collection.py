"""All results that may be of use again: by their keys, so that undo finds the old ones."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal, TypeAlias

from tracker.session import Session
from tracker.session.settings import Quality
from tracker.storage.results.keys import Span, segment_keys
from tracker.storage.results.track import RANK, SegmentTrack

MOST_SEGMENTS = 400
MOST_FRAMES = 60_000
"""Kept at most, about 100 MB for a person's body; what was found longest ago goes first."""

State: TypeAlias = Literal["good", "check", "lost", "outdated", "none"]


@dataclass(frozen=True, eq=False)
class Results:
    """Results by key, the oldest first. Immutable."""

    tracks: Mapping[str, SegmentTrack] = field(default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "tracks", MappingProxyType(dict(self.tracks)))

    def __len__(self) -> int:
        return len(self.tracks)

    def with_track(self, track: SegmentTrack, keep: Collection[str] = ()) -> Results:
        """These and one more, unless a better one of its key is here; then these themselves.

        keep: keys that are never forgotten to make room, such as those of the present segments.
        """
        known = self.tracks.get(track.key)
        if known is not None and not track.supersedes(known):
            return self
        tracks = {key: old for key, old in self.tracks.items() if key != track.key}
        tracks[track.key] = track
        return Results(_bounded(tracks, {*keep, track.key}))

    def fitting(self, session: Session) -> dict[Span, SegmentTrack]:
        """The results that are those of the session's present segments, finished or not."""
        keys = segment_keys(session)
        return {span: self.tracks[key] for span, key in keys.items() if key in self.tracks}

    def wanted(
        self, session: Session, quality: Quality | None = None
    ) -> list[tuple[int, int, str]]:
        """(first, last, key) of the segments without a whole result of at least this quality.

        quality: the session's own when left out.
        """
        least = RANK[quality or session.settings.quality]
        return [
            (*span, key)
            for span, key in segment_keys(session).items()
            if not self._holds(key, least)
        ]

    def states(self, session: Session) -> dict[Span, State]:
        """Of every segment: its verdict; "outdated" where it was tracked otherwise; "none"."""
        keys = segment_keys(session)
        return {span: self._state(span, key) for span, key in keys.items()}

    def _holds(self, key: str, least: int) -> bool:
        track = self.tracks.get(key)
        if track is None or not track.finished or track.missing:
            return False
        return RANK[track.quality] >= least

    def _state(self, span: Span, key: str) -> State:
        track = self.tracks.get(key)
        if track is not None and track.kind is not None:
            return track.kind
        first, last = span
        touched = any(t.first < last and t.last > first for t in self.tracks.values())
        return "outdated" if touched else "none"


def _bounded(tracks: dict[str, SegmentTrack], keep: set[str]) -> dict[str, SegmentTrack]:
    """Without the oldest, as far as there are too many."""
    frames = sum(len(track.trajectory) for track in tracks.values())
    for key, track in list(tracks.items()):
        if len(tracks) <= MOST_SEGMENTS and frames <= MOST_FRAMES:
            break
        if key not in keep:
            del tracks[key]
            frames -= len(track.trajectory)
    return tracks
