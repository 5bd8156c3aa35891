"""Bodies, poses and views on which the mathematics of posing is tried."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from keypose.app.posing import (
    BodyHandle,
    Gesture,
    PointerView,
    Posed,
    drag,
    opening_pose,
    view_rotations,
)
from keypose.app.posing.vectors import unit
from keypose.tracker.body.body import Body, load_body, preset
from keypose.tracker.body.pose import Pose, joint_names, joint_positions, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.storage.files import load_session

Floats = NDArray[np.float64]

SAMPLES = Path(__file__).parents[3] / "sample_videos"
CAMERA = Camera(width=640, height=360, fx=900.0, fy=880.0, cx=330.0, cy=170.0)
TELEPHOTO = CAMERA.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 5.0})
VIEWS = ("main", "top", "side", "front")

PERSON = preset("adult_male")
DOG = preset("dog")
ARMS = load_body(SAMPLES / "bodies" / "three_arms.json")
BOX = load_body(SAMPLES / "bodies" / "box.json")


def sights(camera: Camera = CAMERA) -> dict[str, PointerView]:
    """The four views."""
    small = {name: PointerView.parallel(name, R) for name, R in view_rotations().items()}
    return {"main": PointerView.of(camera), **small}


def standing(body: Body) -> Pose:
    """The body as a fresh session shows it."""
    return _standing(body.model_dump_json())


@cache
def _standing(body: str) -> Pose:
    return opening_pose(Body.model_validate_json(body), CAMERA)


@cache
def walking() -> Pose:
    """The person in the middle of a step, all limbs bent a little."""
    session = load_session(SAMPLES / "person" / "session.json")
    pose = session.subject.keyframes[1].pose(Skeleton.of(session.subject.body))
    return Pose(pose.Rs_parent_part, np.array([0.1, -0.1, 5.0]))


@cache
def tumbling() -> Pose:
    """The gymnast, upside down."""
    session = load_session(SAMPLES / "balance" / "session.json")
    pose = session.subject.keyframes[0].pose(Skeleton.of(session.subject.body))
    return Pose(pose.Rs_parent_part, np.array([-0.2, 0.1, 4.0]))


def bent(body: Body, seed: int, size: float = 0.5) -> Pose:
    """A random pose."""
    rng = np.random.default_rng(seed)
    turns = rng.normal(0, size, (len(body.parts), 3))
    return Pose(exp_rotation(turns), np.array([0.1, 0.0, 4.0]))


def points(body: Body, pose: Pose) -> dict[str, Floats]:
    """Every joint and landmark (3,) in the camera frame."""
    skeleton = Skeleton.of(body)
    p = joint_positions(skeleton, pose_transforms(skeleton, pose))
    return dict(zip(joint_names(skeleton), p, strict=True))


def rotations(body: Body, pose: Pose) -> dict[str, Floats]:
    """R_camera_part (3, 3) by part."""
    Ts = pose_transforms(Skeleton.of(body), pose)
    return dict(zip(body.names, Ts[:, :3, :3], strict=True))


def as_sent(handle: BodyHandle) -> dict[str, str]:
    """The handle as the page names it."""
    if handle.kind == "root":
        return {"kind": "root"}
    return {"kind": "joint" if handle.kind == "middle" else "end", "name": handle.name}


def gesture(view: str, handle: dict[str, Any], start: Any, end: Any, **more: Any) -> Gesture:
    """A drag as the page tells it."""
    spots = {"from": [float(v) for v in start], "at": [float(v) for v in end]}
    return Gesture.model_validate({"view": view, "handle": handle, **spots, **more})


def pull(
    body: Body,
    pose: Pose,
    handle: BodyHandle,
    view: str,
    way_m: Sequence[float],
    *,
    limits_on: bool = True,
    camera: Camera = CAMERA,
    **more: Any,
) -> tuple[Posed, Floats, Floats]:
    """A handle dragged by so many metres, as its depth shows them, right and down in a view.

    The result, where the pointer ended, and where the handle is seen then.
    """
    views = sights(camera)
    sight = views[view]
    p = points(body, pose)[handle.anchor]
    start = sight.project(p)
    end = start + np.array(way_m) / sight.metres_per_unit(p)
    sent = gesture(view, as_sent(handle), start, end, **more)
    posed = drag(body, pose, sent, views, limits_on=limits_on)
    return posed, end, sight.project(points(body, posed.pose)[handle.anchor])


def off_axis(direction: Floats, axis: Floats) -> float:
    """The angle between two directions, radians."""
    return float(np.arccos(np.clip(unit(direction) @ unit(axis), -1, 1)))


def difference(one: Pose, other: Pose) -> float:
    """The largest difference between two poses, radians or metres."""
    turn = np.abs(one.Rs_parent_part - other.Rs_parent_part).max()
    return float(max(turn, np.abs(one.p_camera_root - other.p_camera_root).max()))
