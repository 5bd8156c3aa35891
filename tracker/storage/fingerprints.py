"""What a motion is tracked with, as digests that tell whether it still fits."""

from __future__ import annotations

import hashlib
import json
from typing import Any

from tracker.session.schema import Session


def setup_hash(session: Session) -> str:
    """SHA-256 of what a motion is tracked with besides keyframes: body, camera, ignore masks; or
    body and surfaces.

    Notes, the camera's `origin` and joint limits do not count: they change no motion.
    """
    if session.surface is not None:
        return _surface_hash(session)
    data = session.model_dump(
        mode="json",
        include={"body", "camera", "ignore_masks"},
        exclude={
            "body": {"parts": {"__all__": {"limits_deg"}}},
            "camera": {"origin"},
            "ignore_masks": {"__all__": {"note"}},
        },
    )
    return _hashed(data)


def _surface_hash(session: Session) -> str:
    """The cameras go by their file's content: a folder may be moved as a whole."""
    model = session.model_keyframe
    data = session.model_dump(
        mode="json",
        include={"body", "surface"},
        exclude={
            "body": {"parts": {"__all__": {"limits_deg"}}},
            "surface": {"fps", "model_frame", "cameras"},
        },
    )
    data["meshes"] = session.video.fingerprint
    data["model_frame"] = None if model is None else model.frame
    return _hashed(data)


def _hashed(data: dict[str, Any]) -> str:
    canonical = json.dumps(data, sort_keys=True, separators=(",", ":"))
    return hashlib.sha256(canonical.encode()).hexdigest()


def open_ends(session: Session) -> tuple[int, ...]:
    """Where a motion of surfaces begins or ends without a keyframe; none of a film's."""
    if session.surface is None:
        return ()
    posed = {keyframe.frame for keyframe in session.keyframes}
    return tuple(sorted({0, session.video.frame_count - 1} - posed))
