"""Errors and pictures of a tracked person, for the eye."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from bench.contact_sheet import contact_sheet
from bench.keeping import ROOT
from bench.marked import Person
from bench.table import Pair
from bench.tracking import Tracked
from keypose.app.render.pictures import overlay
from keypose.tracker.body.pose import joint_positions, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory, interpolate, joined
from keypose.tracker.evaluate import Evaluation, JointReference, Spread, evaluate_joints
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.video import Video

OUT = ROOT / "out" / "bench"


@dataclass(frozen=True, eq=False)
class Shown:
    """A film with the body that is drawn over it."""

    video: Path
    camera: Camera
    skeleton: Skeleton


def evaluation(person: Person, found: Tracked, reference: JointReference) -> Evaluation:
    """The errors of what tracking found, at what is known strictly between keyframes."""
    keyframes = [found.trajectories[0].first_frame, *(t.last_frame for t in found.trajectories)]
    whole = joined(found.trajectories)
    known = reference.frames <= whole.last_frame
    reference = replace(
        reference, frames=reference.frames[known], positions=reference.positions[known]
    )
    return evaluate_joints(person.skeleton, person.camera, whole, reference, keyframes)


def pair(spread: Spread, factor: float = 1.0) -> Pair:
    """Mean and median."""
    return Pair(factor * spread.mean, factor * spread.median, ("mean", "median"), digits=1)


def beside_linear(motion: Trajectory, keyframes: list[int]) -> dict[str, Trajectory]:
    """A motion and the interpolation of its keyframes, as lines of a sheet."""
    pieces = [interpolate(motion.pose(a), motion.pose(b), a, b) for a, b in pairwise(keyframes)]
    return {"keypose": motion, "linear": joined(pieces)}


def sheet(
    name: str, shown: Shown, lines: Mapping[str, Trajectory], keyframes: list[int],
    marked: list[int],
) -> Path:  # fmt: skip
    """The body over the pictures, a line for each motion, for a person to look at.

    Shown are the keyframes, the middles between them, and the frames that are marked.
    """
    first = next(iter(lines.values()))
    frames = {(a + b) // 2 for a, b in pairwise(keyframes)} | set(keyframes)
    ordered = sorted(frames | {f for f in marked if first.first_frame <= f <= first.last_frame})
    box = _box(shown, first, ordered)
    pictures, labels = [], []
    with Video.open(shown.video) as video:
        for way, motion in lines.items():
            for frame in ordered:
                pictures.append(_cell(shown, video, motion, frame, box))
                labels.append(f"{frame} {'keyframe' if frame in keyframes else way}")
    OUT.mkdir(parents=True, exist_ok=True)
    place = OUT / f"{name}.png"
    cv2.imwrite(str(place), contact_sheet(pictures, len(ordered), labels)[..., ::-1])
    return place


def _box(shown: Shown, motion: Trajectory, frames: list[int]) -> tuple[int, int]:
    """Width and height of a cut-out in which the body fits at all frames."""
    joints = motion.joints(shown.skeleton)[np.array(frames) - motion.first_frame]
    extent = np.ptp(shown.camera.project(joints), axis=1).max(axis=0)
    return int(1.25 * extent[0] + 40), int(1.2 * extent[1] + 40)


def _cell(
    shown: Shown, video: Video, motion: Trajectory, frame: int, box: tuple[int, int]
) -> NDArray[np.uint8]:
    """The body over the picture, cut out around where it is."""
    camera, pose = shown.camera.without_distortion(), motion.pose(frame)
    picture = overlay(
        shown.camera.rectify(video.frame(frame)), camera, shown.skeleton, pose, style="wire"
    )
    joints = joint_positions(shown.skeleton, pose_transforms(shown.skeleton, pose))
    centre = np.nanmean(camera.project(joints), axis=0)
    size = np.minimum(box, (camera.width, camera.height))
    left, top = np.clip(centre - size / 2, 0, (camera.width, camera.height) - size).astype(int)
    cut = picture[top : top + size[1], left : left + size[0]]
    return np.asarray(cv2.resize(cut, None, fx=1.5, fy=1.5, interpolation=cv2.INTER_CUBIC))
