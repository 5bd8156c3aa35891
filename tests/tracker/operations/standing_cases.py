"""A tracked walk before a camera that looks down, in a session as a draft leaves it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.up import UpEvidence
from keypose.tracker.session import Session
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.storage.results import Results, segment_key
from keypose.tracker.tracking.result import Diagnostics, SegmentResult
from keypose.tracker.video.upright_lines import UprightLines
from tests.rendering.scenes import Scene, scene
from tests.tracker import session_cases as cases

FPS = 30.0
KEYS = (0, 30, 60, 90)
TILT_DEG = 10.0


def walk(tilt_deg: float = TILT_DEG) -> tuple[Scene, Array]:
    """Somebody who strides, seen by a camera that looks down; and what is up in it."""
    shown = scene("stride").cut(0, KEYS[-1])
    R = Rotation.from_euler("x", tilt_deg, degrees=True).as_matrix()
    Rs, ps = shown.truth.writable()
    middle = ps.mean(axis=0)
    Rs[:, 0], ps = R @ Rs[:, 0], (ps - middle) @ R.T + middle
    return replace(shown, truth=Trajectory(0, Rs, ps)), R @ [0.0, -1.0, 0.0]


def lines(up: Array, share: float = 0.6, sigma_deg: float = 0.5) -> UprightLines:
    """Upright lines of a film that show what is up."""
    return UprightLines(UpEvidence.of(up, np.radians(sigma_deg), "lines"), share)


def wandering(motion: Trajectory, most_m: float = 0.06) -> Trajectory:
    """The motion as one camera tracks it: nearer and farther by some centimetres over a second."""
    phase = np.arange(len(motion)) * 2 * np.pi / FPS
    away = most_m * np.sin(phase)[:, None] * motion.ps_camera_root
    depth = motion.ps_camera_root[:, 2:]
    return Trajectory(
        motion.first_frame, motion.Rs_parent_part, motion.ps_camera_root + away / depth
    )


def session_of(shown: Scene, motion: Trajectory, **changes: Any) -> Session:
    """With a keyframe in every second, as tracked there."""
    given = cases.session()
    video = given.view.video.model_copy(
        update={
            "frame_count": len(motion), "width": shown.camera.width, "height": shown.camera.height,
        }
    )  # fmt: skip
    keyframes = tuple(
        Keyframe.of(shown.skeleton, motion.pose(frame), frame, frame / FPS) for frame in KEYS
    )
    made = {
        "video": video, "camera": shown.camera, "body": shown.skeleton.body,
        "keyframes": keyframes, "settings": TrackSettings(smooth=True),
    }  # fmt: skip
    return given.changed({**made, **changes})


def tracked(session: Session, motion: Trajectory) -> dict[Span, SegmentResult]:
    """The motion as what was tracked between its keyframes."""
    found = {}
    for first, last in session.spans:
        R, t = motion.Rs_parent_part[first : last + 1], motion.ps_camera_root[first : last + 1]
        steps, parts = last - first, len(session.subject.body.parts)
        seen = np.full((steps, parts), 0.9)
        values = np.ones((steps, Skeleton.of(session.subject.body).dof_count))
        diagnostics = Diagnostics(np.full(steps, 3), values, seen, np.ones_like(seen))
        whole = replace(
            cases.segment(0, 4), trajectory=Trajectory(first, R, t), diagnostics=diagnostics
        )
        found[first, last] = replace(whole, key=segment_key(session, first, last), quality="full")
    return found


def results_of(session: Session, motion: Trajectory) -> Results:
    """The same, by their keys."""
    results = Results()
    for segment in tracked(session, motion).values():
        results = results.with_result(segment)
    return results
