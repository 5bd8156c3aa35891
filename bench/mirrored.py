"""Limbs that one keyframe has the wrong way round in depth: how many are reported, and how many
right ones."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from bench.keyed import jittered
from bench.table import Expected, Report
from bench.tracking import keyframes_every
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.solver.depth_turn import turned_in_depth, turns_round
from keypose.tracker.tracking.space.mirrored import APART_M, mirrored_limbs
from tests.rendering.scenes import Scene, scene

MOTIONS = ("walk", "throw", "stride", "jump", "speech", "jumping_jacks", "wash")
INTERVAL = 20
RATES = {"jump": 60.0}
"""Frames a second where they are not 30."""
SAME_PX = 4.0
"""A limb seen farther off than this is no mirror image."""
FAR_M = 0.25
LIMBS = ("upper_arm", "forearm", "thigh", "shin")


def mirrored(report: Report) -> None:
    """A table by motion, keyframes disturbed as a hand would; each limb mirrored in turn."""
    table = report.table(
        f"a limb mirrored at one keyframe of every {INTERVAL} frames: reported, of how many",
        "far reported", "of far", "near reported", "of near", "right reported", "of right",
    )  # fmt: skip
    total = np.zeros(6)
    for name in MOTIONS:
        try:
            shown = scene(name)
        except FileNotFoundError:
            report.note(f"left out: the recorded motion of {name!r} is not here")
            continue
        row = _counted(shown, RATES.get(name, 30.0))
        total += row
        table.row(name, *row.tolist())
    missed = Expected("far ones missed", 1 - total[0] / max(total[1], 1), 0.4)
    false = Expected("right ones reported", total[4] / max(total[5], 1), 0.02)
    table.row("all", *total.tolist(), expected=[missed, false])


def _counted(shown: Scene, rate: float) -> Array:
    """(6,) far, near and right limbs: how many are reported, and how many there are."""
    frames = keyframes_every(INTERVAL, 0, len(shown.truth) - 1)
    known = jittered(shown.skeleton, {f: shown.truth.pose(f) for f in frames}, 1)
    right = mirrored_limbs(shown.skeleton, shown.camera, known, rate)
    counts = np.array([0, 0, 0, 0, len(right), len(LIMBS) * len(frames)], dtype=np.float64)
    for frame, part, pose, apart_m in _turned(shown, known):
        found = mirrored_limbs(shown.skeleton, shown.camera, {**known, frame: pose}, rate)
        reported = any(one.frame == frame and _limb(one.part) == _limb(part) for one in found)
        at = 0 if apart_m >= FAR_M else 2
        counts[at : at + 2] += reported, 1
    return counts


def _turned(shown: Scene, known: Mapping[int, Pose]) -> Iterator[tuple[int, str, Pose, float]]:
    """Frame, part and pose of every limb that can be mirrored, and how far its joints are apart."""
    skeleton, camera = shown.skeleton, shown.camera
    parts = [f"{side}_{kind}" for side in ("left", "right") for kind in LIMBS]
    for frame, pose in known.items():
        for part in parts:
            top = skeleton.body.index(part)
            turned = turned_in_depth(skeleton, camera, pose, top)
            far = skeleton.below[:, top] & (np.arange(skeleton.part_count) != top)
            p, q = (pose_transforms(skeleton, one)[far, :3, 3] for one in (pose, turned))
            apart = float(np.linalg.norm(p - q, axis=-1).mean())
            px = np.linalg.norm(camera.project(p) - camera.project(q), axis=-1).mean()
            if apart >= APART_M and px <= SAME_PX and turns_round(skeleton, pose, turned, top):
                yield frame, part, turned, apart


def _limb(part: str) -> tuple[str, bool]:
    """Side, and whether it is a leg."""
    side, kind = part.split("_", 1)
    return side, kind in LIMBS[2:]
