"""Sizes fitted to rendered people: how much of what was wrong is found, and what stays right."""

from __future__ import annotations

import time
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from bench.sequences import video_of
from bench.table import Expected, Report, Table
from bench.wrong_preset import wrong_preset
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.modify import resized
from keypose.tracker.body.pose import Pose, joint_positions, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.sizes import Proposal
from keypose.tracker.fitting.sizes import fit_sizes as fit
from keypose.tracker.fitting.sizes.proportions import Proportions
from keypose.tracker.solver.fit_joints import fit_picture
from keypose.tracker.solver.posed import BodyPoint
from tests.rendering import motions
from tests.rendering.render import render
from tests.rendering.scenes import camera
from tests.rendering.settings import RenderSettings

GIVEN = preset("adult_male")
CAMERA = camera()
FRAMES = {"stride": (5, 30, 55, 80, 110), "throw": (5, 35, 60, 80, 110)}
OTHERS = (0, 45, 70, 95, 119)
LIMBS = ("upper_arm", "forearm", "thigh", "shin")
WRONG: Mapping[str, tuple[tuple[str, ...], float, float]] = {
    "right sizes": ((), 1.0, 1.0),
    "long": (("forearm", "shin"), 1.08, 1.0),
    "thick": (LIMBS, 1.0, 1.15),
}
"""Which parts of the person differ from the body, by how much in length and in thickness."""
LOOKS = {
    "": RenderSettings(),
    "noise": RenderSettings(noise=12.0),
    "pan": RenderSettings(pan_px_per_frame=3.0),
}
POSED_PX = 2.0
"""How far off joints are posed, in the rows that say so."""


def fit_sizes(report: Report) -> None:
    """The whole group."""
    report.note("five keyframes posed by the person's joints with another body; found, and how far")
    report.note("other sizes moved, as shares of the size; seconds of one run on a busy machine")
    table = report.table("sizes", "found", "of", "others", "joints px", "s", wide=("found",))
    for motion in FRAMES:
        for kind in WRONG:
            for look, off in (("", 0.0), ("", POSED_PX), ("noise", 0.0), ("pan", 0.0)):
                name = f"{motion} {kind} {look or (f'{off:.0f} px off' if off else '')}".rstrip()
                _row(table, name, motion, kind, look, off)
    wrong_preset(report)


def _row(table: Table, name: str, motion: str, kind: str, look: str, off: float) -> None:
    person = _person(kind)
    truth, pictures, keys = _shown(motion, person, LOOKS[look])
    keyposes = {k: _posed(person, truth.pose(k), off, k) for k in keys}
    began = time.perf_counter()
    fitted = fit(video_of(len(pictures), lambda k: pictures[k]), CAMERA, GIVEN, keyposes)
    seconds = time.perf_counter() - began
    found = fitted.with_poses or Proposal(GIVEN, CAMERA, keyposes, (), fitted.error_px, {})
    given = Proportions.of(GIVEN)
    ours, true = (
        np.log(Proportions.of(body).metres() / given.metres()) for body in (found.body, person)
    )
    wrong = np.abs(true) > 1e-9
    share = float(ours[wrong].sum() / true[wrong].sum()) if wrong.any() else float("nan")
    others = float(np.abs(ours[~wrong]).max())
    away = [_pixels(found.body, found.keyposes[k]) - _pixels(person, truth.pose(k)) for k in keys]
    px = float(np.linalg.norm(away, axis=-1).mean())
    expected = [Expected("others", others, 0.02)] if not off else []
    listed = ", ".join(f"{v:+.1%}" for v in np.expm1(ours[wrong])) or "–"
    table.row(name, listed, share, others, px, seconds, expected=expected)


def _person(kind: str) -> Body:
    names, length, thickness = WRONG[kind]
    body = GIVEN
    for name in names:
        body = resized(body, f"left_{name}", length_factor=length, thickness_factor=thickness)
    return body


def _shown(
    motion: str, person: Body, look: RenderSettings
) -> tuple[Trajectory, NDArray[np.uint8], list[int]]:
    """The person's poses and pictures, and which of them are keyframes."""
    skeleton = Skeleton.of(person)
    whole: Trajectory = getattr(motions, motion)(skeleton)
    frames = sorted({*FRAMES[motion], *OTHERS})
    truth = Trajectory(0, whole.Rs_parent_part[frames], whole.ps_camera_root[frames])
    keys = [frames.index(frame) for frame in FRAMES[motion]]
    return truth, render(skeleton, truth, CAMERA, look), keys


def _posed(person: Body, pose: Pose, off_px: float, seed: int) -> Pose:
    """The given body with its joints where the person's are seen."""
    uv = _pixels(person, pose)
    uv = uv + np.random.default_rng(seed).normal(0.0, off_px, uv.shape)
    own: list[BodyPoint] = [((i, (0.0, 0.0, 0.0)),) for i in range(len(GIVEN.parts))]
    own += [((i, p),) for i, part in enumerate(GIVEN.parts) for p in part.landmarks.values()]
    return fit_picture(GIVEN, CAMERA, own, uv, np.ones(len(uv)), [pose], pose).pose


def _pixels(body: Body, pose: Pose) -> NDArray[np.float64]:
    skeleton = Skeleton.of(body)
    return CAMERA.project(joint_positions(skeleton, pose_transforms(skeleton, pose)))
