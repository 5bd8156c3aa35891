"""Drafts of a filmed man from four cameras: limbs that point the wrong way in depth, and whether
they are marked.

A bone is mirrored that points toward the camera where the rough joints of the four views have it
point away, or the other way about, each steeper than what is taken to be in the picture's plane. A
limb is marked where it is doubted by half or more, and proposed where a person is asked to look.
"""

from __future__ import annotations

import numpy as np

from bench.clips import beam_camera
from bench.table import Expected, Report
from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.fitting.draft import ClipDraft, draft_clip
from keypose.tracker.fitting.draft.depth_signs import PLANE, tilt
from keypose.tracker.fitting.draft.observed import LIMBS, SIDES, Joints
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.detectors import open_detector
from keypose.tracker.keypoints.model_files import find_model
from keypose.tracker.video import Video

CAMERAS = (1, 2, 3, 4)
NETWORKS = ("full", "thunder")
ROOM = 0.08
"""Share of the person's height around the joints, as a box is drawn."""
MOST_FALSE = 0.5
"""Of the limbs that are marked no more should be right: marks are not believed otherwise."""


def drafts(report: Report) -> None:
    """A row by camera. Limbs are counted frame by frame; unmarked are drafts with a limb that is
    mirrored and not marked; mm of all joints from the rough ones, both seen from the hips."""
    table = report.table(
        "drafts from one box, limbs",
        "drafts",
        "mirrored",
        "marked",
        "of them mirr.",
        "unmarked",
        "proposed",
        "of them mirr.",
        "mm",
    )
    for network in NETWORKS:
        total, apart = np.zeros(7), []
        for number in CAMERAS:
            counts, mm = _of_camera(number, network)
            total += counts
            apart.append(mm)
            table.row(f"camera {number}, {network}", *counts.tolist(), mm)
        _, _, marked, mirrored, unmarked, _, _ = total
        expected = [
            Expected("drafts mirrored unmarked", unmarked, 0.0),
            Expected("marked, but not mirrored", 1 - mirrored / max(marked, 1), MOST_FALSE),
        ]
        table.row(f"all, {network}", *total.tolist(), np.mean(apart), expected=expected)


def _of_camera(number: int, network: str) -> tuple[Array, float]:
    """(7,) what the columns count, and the joints' mean distance from the rough ones, mm."""
    film, camera, names, rough = beam_camera(number)
    with Video.open(str(film)) as video:
        pictures = [picture for _, picture in video.frames(0, video.info.frame_count)]
        half = find_model(network).skips_frames_at(video.info.fps)
    box = _box(camera, rough[0])
    ends = 0, len(pictures) - 1
    detector = open_detector(find_model(network))
    body = preset("adult_male")
    draft = draft_clip(
        lambda n: pictures[n], ends, 0, box, camera, body, detector, every_second=half
    )
    return _counted(draft, camera, rough[:, [names.index(name) for name in _names()]])


def _names() -> list[str]:
    """Of the rough joints, in the order of the drafts'."""
    joints = [joint for limb in LIMBS for joint in limb]
    return [f"{side[0].upper()}{joint.title()}" for joint in joints for side in SIDES]


def _box(camera: Camera, p: Array) -> tuple[float, float, float, float]:
    uv = camera.project(p)
    low, high = uv.min(axis=0), uv.max(axis=0)
    room = ROOM * float(high[1] - low[1])
    left, top = np.maximum(low - room, 0).tolist()
    right, bottom = np.minimum(high + room, (camera.width - 1, camera.height - 1)).tolist()
    return left, top, right, bottom


def _counted(draft: ClipDraft, camera: Camera, rough: Array) -> tuple[Array, float]:
    joints, ideal = Joints.of(Skeleton.of(draft.body)), camera.without_distortion()
    frames = list(draft.judged.frames)
    poses = [draft.poses[frame] for frame in frames]
    p = np.stack([joints.points.at(pose_transforms(joints.skeleton, pose)) for pose in poses])
    rough = rough[frames]
    ours, theirs = (
        np.stack([tilt(ideal, q, bone) for bone in joints.bones], axis=1) for q in (p, rough)
    )
    steep = np.minimum(np.abs(ours), np.abs(theirs)) >= PLANE
    bones = (ours * theirs < 0) & steep
    mirrored, marked = bones[:, 0::2] | bones[:, 1::2], draft.judged.flips >= 0.5
    proposed = [
        mirrored[frames.index(one.frame), draft.judged.parts.index(part)]
        for one in draft.proposals
        if one.reason == "flip"
        for part in one.parts or draft.judged.parts
    ]
    unmarked = (mirrored & ~marked).any(axis=1).sum()
    found = (len(frames), mirrored.sum(), marked.sum(), (mirrored & marked).sum(), unmarked)
    hips = [_names().index(f"{side}Hip") for side in "LR"]
    p, rough = (q - q[:, hips].mean(axis=1, keepdims=True) for q in (p, rough))
    mm = 1e3 * float(np.linalg.norm(p - rough, axis=-1).mean())
    return np.array([*found, len(proposed), sum(proposed)], dtype=np.float64), mm
