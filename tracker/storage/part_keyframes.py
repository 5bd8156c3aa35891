"""A session's part keyframes as the tracker takes them."""

from __future__ import annotations

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session.schema import Session
from keypose.tracker.tracking.parts.keyed import KeyedParts


def keyed_parts(session: Session, skeleton: Skeleton) -> list[KeyedParts]:
    """What is exact at frames between keyframes."""
    telephoto = session.camera.projection == "telephoto"
    return [
        KeyedParts.of(skeleton, keyframe.frame, keyframe.parts, keyframe.pose(skeleton), telephoto)
        for keyframe in session.part_keyframes
    ]
