"""A segment's key: equal where its motion comes out equal.

The quality is not in it: preview, fast and full results of one key are the same motion, found with
more and more care. Of observed surfaces other things decide than of pictures: how the meshes are
read and weighed, and the pose in the mesh that moves with the body; never the camera, which only
looks at them.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np

from tracker.geometry.rotations import rotation_from_quaternion
from tracker.session import IgnoreMask, Keyframe, Session

Span: TypeAlias = tuple[int, int]
"""First and last frame of a segment, as in Session.spans."""

DECIMALS = 9
"""Poses that agree to a billionth of a metre or radian are the same pose."""
AT_REST = (1.0, 0.0, 0.0, 0.0)


def segment_keys(session: Session) -> dict[Span, str]:
    """The keys of all segments of a session, in the order of their frames."""
    return dict(_keys(_Same(session)))


@lru_cache(maxsize=8)
def _keys(session: _Same) -> dict[Span, str]:
    """Asked for many times while a session stays as it is."""
    setup = _setup(session.it)
    at = {keyframe.frame: keyframe for keyframe in session.it.keyframes}
    return {span: _key(session.it, setup, at, span) for span in session.it.spans}


def segment_key(session: Session, first: int, last: int) -> str:
    """The key of one segment; KeyError where the session has no such segment."""
    at = {keyframe.frame: keyframe for keyframe in session.keyframes}
    if session.surface is not None and (first, last) not in session.spans:
        raise KeyError((first, last))
    return _key(session, _setup(session), at, (first, last))


def _key(session: Session, setup: bytes, at: Mapping[int, Keyframe], span: Span) -> str:
    names = session.body.names
    if session.surface is None:
        told, ends = [span, _masks(session.ignore_masks, span)], [at[frame] for frame in span]
    else:  # of an open end nobody has posed anything
        ends = [at[frame] for frame in span if frame in at]
        told = [span, [end.frame for end in ends]]
    poses = [_pose(_Same(end), names) for end in ends]
    return hashlib.sha256(b"\0".join((setup, json.dumps(told).encode(), *poses))).hexdigest()


def _masks(masks: tuple[IgnoreMask, ...], span: Span) -> list[Any]:
    """What masks do within the segment; each frame has its own, so that the rest does not count."""
    first, last = span
    within = [
        (max(first, mask.first_frame), min(last, mask.last_frame), mask.polygon)
        for mask in masks
        if mask.first_frame <= last and mask.last_frame >= first
    ]
    return sorted(within)


def _setup(session: Session) -> bytes:
    """What decides every segment's motion besides its poses and masks."""
    if session.surface is not None:
        return _surface_setup(session)
    settings = session.settings.model_dump(mode="json", exclude={"quality", "initial", "left_out"})
    setup = [_body(_Same(session.body)), _camera(_Same(session.camera)), settings, *_start(session)]
    return hashlib.sha256(json.dumps(setup, sort_keys=True).encode()).digest()


def _surface_setup(session: Session) -> bytes:
    """The same of surfaces: the body as it was posed in the mesh that moves with it, the meshes,
    and how they are read. A folder may be moved as a whole, so cameras go by their file's content.
    """
    surface, model = session.surface, session.model_keyframe
    assert surface is not None
    told = surface.model_dump(mode="json", exclude={"fps", "model_frame", "cameras"})
    setup: list[Any] = ["surface", _body(_Same(session.body)), told, session.video.fingerprint]
    if model is not None:
        pose = hashlib.sha256(_pose(_Same(model), session.body.names)).hexdigest()
        setup += [model.frame, pose]
    return hashlib.sha256(json.dumps(setup, sort_keys=True).encode()).digest()


def _start(session: Session) -> list[Any]:
    """What segments start from, besides the method's own start; nothing where that is all."""
    initial, first_motion = session.settings.initial, session.first_motion
    if initial in ("linear", "both-ways"):
        return [initial]
    left_out = sorted(set(session.settings.left_out))
    if initial == "templates":
        return [initial, left_out]
    start: list[Any] = [] if first_motion is None else [initial, first_motion.file]
    return [*start, left_out] if left_out and initial == "auto" else start


class _Same:
    """An object that never changes, known by its identity: quicker than by all it holds."""

    def __init__(self, it: Any) -> None:
        self.it = it

    def __hash__(self) -> int:
        return id(self.it)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and self.it is other.it


@lru_cache(maxsize=8)
def _body(body: _Same) -> str:
    """Names of parts stay in, for the verdict speaks them; what is only a caption goes."""
    parts = {"__all__": {"limits_deg"}}  # posing keeps to them, tracking knows none
    captions = {"name": True, "source": True, "mirror_pairs": True}
    data = body.it.model_dump(mode="json", exclude={**captions, "parts": parts})
    return json.dumps(data, sort_keys=True)


@lru_cache(maxsize=8)
def _camera(camera: _Same) -> str:
    return json.dumps(camera.it.model_dump(mode="json", exclude={"origin"}), sort_keys=True)


@lru_cache(maxsize=4096)
def _pose(keyframe: _Same, names: tuple[str, ...]) -> bytes:
    """The pose as numbers, the same however its quaternions were signed or left out."""
    wxyz = np.array([keyframe.it.rotations_wxyz.get(name, AT_REST) for name in names])
    numbers = np.concatenate([rotation_from_quaternion(wxyz).ravel(), keyframe.it.root_m])
    return (np.round(numbers, DECIMALS) + 0.0).tobytes()  # + 0.0: there is no minus nought
