"""Networks against marks: what each sees of filmed people, alone and together.

Every look is taken once and kept, so that another way to put looks together is a matter of seconds.
All are taken where BlazePose, looking once a frame, follows the person from a box around the marks
of the first marked frame. Pixels are those of a person 400 px tall; `own place` is what is left of
them when each joint's mean offset on the clip's other frames is taken off: a detector's places of
joints are not those of a person who marks. Costs are processor time of the looks, of this run.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import TypeAlias

import numpy as np

from bench.clips import Clip, beam_camera, clip
from bench.keeping import ROOT, digest, place_for
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.augmented import VARIATIONS, Variation
from keypose.tracker.keypoints.blazepose import NAMES, BlazePose
from keypose.tracker.keypoints.detect import LOOK_PARTS, Rows
from keypose.tracker.keypoints.joint_network import JointNetwork
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.model_files import THUNDER
from keypose.tracker.keypoints.region import Region
from keypose.tracker.video import Video

CLIPS = {
    "person": (0, 99), "walk": (30, 90), "arms": (20, 90),
    "camera1": (0, 99), "camera2": (0, 99), "camera3": (0, 99), "camera4": (0, 99),
}  # fmt: skip
"""First and last frame by clip."""
SHORT = {
    f"{side[0].upper()}{joint.title()}": f"{side}_{joint}"
    for side in ("left", "right")
    for joint in ("shoulder", "elbow", "wrist", "hip", "knee", "ankle")
}
LOOKS = (Variation(), *VARIATIONS)


@dataclass(frozen=True, eq=False)
class Looks:
    """All looks at F frames of a clip.

    uv (F, L, 12, 2), visibility (F, L, 12), p_hips (F, L, 12, 3): of BlazePose's plain look and its
    variations, the sides of each as the network has them.  thunder (F, 12, 2), heat (F, 12): of
    MoveNet.  marks (F, 12, 2): NaN where none.  tall_px (F,).
    seconds: processor time of a look of BlazePose, and of MoveNet.
    """

    frames: Array
    uv: Array
    visibility: Array
    p_hips: Array
    thunder: Array
    heat: Array
    marks: Array
    tall_px: Array
    seconds: Array


Way: TypeAlias = Callable[[Looks], Array]
"""From looks to joints (F, 12, 2)."""


def marked(
    name: str,
) -> tuple[str, dict[int, dict[str, tuple[float, float]]], Callable[[int], float]]:
    """A clip's film, its marks by frame and joint, and how tall the person is in a frame, px."""
    if name.startswith("camera"):
        film, camera, names, joints = beam_camera(int(name[-1]))
        uv = np.stack([camera.project(p) for p in joints])
        known = {
            f: {
                SHORT[n]: tuple(at)
                for n, at in zip(names, uv[f].tolist(), strict=True)
                if np.isfinite(at).all()
            }
            for f in range(len(uv))
        }
        return str(film), known, lambda f: 1.70 * camera.fy / float(np.nanmean(joints[f, :, 2]))
    shown: Clip = clip(name)
    known = {
        f: {SHORT[n]: uv for n, uv in js.items() if n in SHORT} for f, js in shown.marks.items()
    }
    tall = {"person": 405.0, "walk": 216.0, "arms": 265.0}[name]
    return str(shown.video), known, lambda f: tall


@cache
def looks(name: str) -> Looks:
    """All looks at a clip, taken or as kept."""
    film, known, tall = marked(name)
    kept = place_for(
        f"looks-{name}",
        digest(
            ROOT / "tracker/keypoints/blazepose.py",
            ROOT / "tracker/keypoints/joint_network.py",
            repr(VARIATIONS).encode(),
        ),
        ".npz",
    )
    if not kept.is_file():
        np.savez(kept, **_looked(film, known, CLIPS[name]))
    with np.load(kept) as found:
        frames = found["frames"].tolist()
        marks = np.full((len(frames), len(JOINTS), 2), np.nan)
        for row, f in enumerate(frames):
            for joint, uv in known.get(f, {}).items():
                marks[row, JOINTS.index(joint)] = uv
        return Looks(marks=marks, tall_px=np.array([tall(f) for f in frames]), **found)


def _looked(
    film: str, known: Mapping[int, Mapping[str, tuple[float, float]]], ends: tuple[int, int]
) -> dict[str, Array]:
    net, thunder = BlazePose.open(), JointNetwork.open(THUNDER)
    at = [NAMES.index(j) for j in JOINTS]
    mn = [thunder.names.index(j) for j in JOINTS]
    with Video.open(film) as video:
        first = min(known)
        uv = np.array(list(known[first].values()))
        low, high = uv.min(axis=0), uv.max(axis=0)
        room = float((high - low).max())
        box = (
            low[0] - 0.05 * room,
            low[1] - 0.22 * room,
            high[0] + 0.05 * room,
            high[1] + 0.08 * room,
        )
        picture = video.frame(first)
        region = Rows.begun(
            Region.of_box(box, picture.shape[1], picture.shape[0]), net, picture, 3
        ).region
        rows: dict[int, tuple[Array, ...]] = {}
        spent = np.zeros(3)
        for way in (range(first, ends[1] + 1), range(first - 1, ends[0] - 1, -1)):
            now = region
            for f in way:
                picture, here = video.frame(f), now.rounded(LOOK_PARTS)
                began = time.process_time()
                seen = [net.infer(picture, v.of(here), mirrored=v.mirrored) for v in LOOKS]
                between = time.process_time()
                other = thunder.infer(picture, here)
                spent += between - began, time.process_time() - between, 1
                rows[f] = (
                    np.stack([s.uv[at] for s in seen]), np.stack([s.visibility[at] for s in seen]),
                    np.stack([s.p_hips[at] for s in seen]), other.uv[mn], other.confidence[mn],
                )  # fmt: skip
                now = seen[0].next
    frames = sorted(rows)
    found = (np.stack([rows[f][k] for f in frames]) for k in range(5))
    named = dict(zip(("uv", "visibility", "p_hips", "thunder", "heat"), found, strict=True))
    return {"frames": np.array(frames), **named, "seconds": spent[:2] / spent[2] / (len(LOOKS), 1)}
