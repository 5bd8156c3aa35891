"""A session's part keyframes as the tracker takes them."""

from __future__ import annotations

from tracker.body.skeleton import Skeleton
from tracker.session.schema import Session
from tracker.tracking.parts.keyed import KeyedParts


def keyed_parts(session: Session, skeleton: Skeleton) -> list[KeyedParts]:
    """What is exact at frames between keyframes."""
    return [
        KeyedParts.of(skeleton, keyframe.frame, keyframe.parts, keyframe.pose(skeleton))
        for keyframe in session.part_keyframes
    ]
