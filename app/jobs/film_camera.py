"""How the camera of a second film moves, from the background of its pictures."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from keypose.app.jobs.find_camera import with_found
from keypose.tracker.errors import SessionError
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.operations.find_camera import find_camera
from keypose.tracker.session import Session
from keypose.tracker.session.settings import IgnoreMask
from keypose.tracker.session.views import View
from keypose.tracker.video import Video

MASK_FRAMES = 5
"""Frames that share a mask around a person."""
MARGIN = 0.25
"""Around a person's joints, of their extent: hands, hair, clothes."""


def with_camera_motion(
    session: Session,
    view: View,
    video: Video,
    people: Sequence[Keypoints],
    report: Callable[[float], None],
) -> View:
    """A view with its camera's motion as its background shows it; as it was where that stands
    still.

    people: the keypoints of those who are seen in it, who are no background.  report: receives the
    share that is done; what it raises ends the work.  SessionError where the camera cannot be
    followed through the whole film.
    """
    if view.video.stands_still is not False:
        return view
    masks = tuple(mask for keypoints in people for mask in _around(keypoints, view))
    masked = view.model_copy(update={"ignore_masks": (*view.ignore_masks, *masks)})
    camera_found = find_camera(of_view_alone(session, masked), video, {}, report=report)
    if camera_found.motion is not None and len(camera_found.motion.pieces) > 1:
        frame = camera_found.motion.pieces[1].first_frame
        raise SessionError(
            f"{Path(view.video.path).name} is cut at frame {frame}, or shows too little background "
            "there to follow its camera: cut the film there, and add one part."
        )
    after = with_found(of_view_alone(session, view), camera_found).view
    return after.model_copy(update={"id": view.id})


def of_view_alone(session: Session, view: View) -> Session:
    """A session about a view that is not in it yet, without anything posed."""
    both = session.model_copy(update={"views": (*session.views, view)})
    return both.alone(view.id).changed({"keyframes": (), "part_keyframes": (), "drafts": ()})


def _around(keypoints: Keypoints, view: View) -> Iterator[IgnoreMask]:
    """Boxes around a person, a few frames each."""
    count = view.video.frame_count
    over = keypoints.over(0, count - 1)
    for first in range(0, count, MASK_FRAMES):
        last = min(first + MASK_FRAMES, count) - 1
        box = _box(over.uv[first : last + 1].reshape(-1, 2))
        if box is None:
            continue
        left, top, right, bottom = box
        corners = ((left, top), (right, top), (right, bottom), (left, bottom))
        yield IgnoreMask(polygon=corners, first_frame=first, last_frame=last)


def _box(uv: Array) -> tuple[float, float, float, float] | None:
    joints = uv[np.isfinite(uv).all(axis=1)]
    if not len(joints):
        return None
    low, high = joints.min(axis=0), joints.max(axis=0)
    margin = MARGIN * float((high - low).max())
    (left, top), (right, bottom) = low - margin, high + margin
    return float(left), float(top), float(right), float(bottom)
