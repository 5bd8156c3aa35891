"""The motion that is known now, in one value."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from keypose.tracker.session.schema import Session
from keypose.tracker.storage.results import Fitting, Results, Span
from keypose.tracker.tracking.result import SegmentResult


@dataclass(frozen=True, eq=False)
class KnownMotion:
    """What was found of the motion, for whichever keyframes, and what is shown of it.

    results:  what was tracked, and solved for in space, by what it was made from.
    gesture:  name of the gesture whose poses are previewed; empty where none is.
    previews: the newest preview of each segment that this gesture changes.
    bent:     shown in place of the results of the present segments; None where these are.
    """

    results: Results = field(default_factory=Results)
    gesture: str = ""
    previews: Mapping[Span, SegmentResult] = field(default_factory=dict)
    bent: Fitting | None = None

    def fitting(self, doc: Session) -> Fitting:
        """The motion of a document's segments."""
        return self.results.fitting(doc) if self.bent is None else self.bent

    def previews_of(self, gesture: str) -> Mapping[Span, SegmentResult]:
        """The previews for poses of a gesture; none of any other's."""
        return self.previews if self.gesture == gesture else {}

    def with_preview(self, gesture: str, segment: SegmentResult) -> KnownMotion:
        """The same with a newer preview for a pose of a gesture."""
        previews = {**self.previews_of(gesture), segment.span: segment}
        return replace(self, gesture=gesture, previews=previews)

    def without_previews(self) -> KnownMotion:
        """The same once no gesture is previewed any more."""
        return replace(self, gesture="", previews={}) if self.gesture else self
