"""Sizes fitted to rendered people: how much of what was wrong is found, and what stays right."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from bench.sequences import video_of
from bench.table import Expected, Report, Table
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.modify import height, resized, scaled, with_height
from keypose.tracker.body.pose import Pose, joint_positions, pose_transforms
from keypose.tracker.body.raster import BodyMesh
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.fitting.sizes import Proposal
from keypose.tracker.fitting.sizes import fit_sizes as fit
from keypose.tracker.fitting.sizes.proportions import Proportions
from keypose.tracker.geometry.rotations import Array, exp_rotation
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
TALLER = (1.08, 1 / 1.08)
LIMB_SHARE = 0.10
SEEDS = (1, 2, 3)
TURNED_DEG = 4.0
DEPTH_SHARE = 0.01
"""How far off a hand poses a turn that it cannot see, and depth."""
NEAR_CM = 0.5
UP = np.array([0.0, -1.0, 0.0])


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
    return _on(uv + np.random.default_rng(seed).normal(0.0, off_px, uv.shape), pose)


def _on(uv: Array, start: Pose) -> Pose:
    """The given body with its joints and landmarks at these pixels."""
    own: list[BodyPoint] = [((i, (0.0, 0.0, 0.0)),) for i in range(len(GIVEN.parts))]
    own += [((i, p),) for i, part in enumerate(GIVEN.parts) for p in part.landmarks.values()]
    return fit_picture(GIVEN, CAMERA, own, uv, np.ones(len(uv)), [start], start).pose


def _pixels(body: Body, pose: Pose) -> NDArray[np.float64]:
    skeleton = Skeleton.of(body)
    return CAMERA.project(joint_positions(skeleton, pose_transforms(skeleton, pose)))


# --- keyframes that a hand posed with a wrong preset: what is nearer, what leans


@dataclass(frozen=True, eq=False)
class _Case:
    """A person, the pictures and true poses, and keyframes posed by hand with the given body."""

    person: Body
    pictures: NDArray[np.uint8]
    keyposes: Mapping[int, Pose]


def wrong_preset(report: Report) -> None:
    """One camera does not tell a small body near from a large one far away: sizes are compared with
    the person's at the same height, of ten kinds of parts."""
    report.note("posed by hand with a preset 8 % too tall or short, limbs 10 % too long, short,")
    report.note(
        "thick or thin. nearer: of 10 parts, to the person's sizes at equal height or within"
    )
    report.note("0.5 cm; off: mean share before/after; lean, float: the most that was added.")
    columns = (
        "outline px",
        "long nearer",
        "off",
        "wide nearer",
        "off wide",
        "lean deg",
        "float cm",
    )
    table = report.table("wrong preset", *columns, wide=("outline px", "off", "off wide"))
    for motion in FRAMES:
        found: dict[str, list[Array]] = {"alone": [], "with poses": []}
        for tall in TALLER:
            for seed in SEEDS:
                case = _case(motion, tall, seed)
                video = video_of(len(case.pictures), lambda k, case=case: case.pictures[k])
                fitted = fit(video, CAMERA, GIVEN, case.keyposes)
                unchanged = Proposal(GIVEN, CAMERA, case.keyposes, (), fitted.error_px, {})
                for name, some in (("alone", fitted.alone), ("with poses", fitted.with_poses)):
                    found[name].append(_figures(case, fitted.error_px, some or unchanged))
        for name, rows in found.items():
            _preset_row(table, f"{motion}, {name}", np.array(rows))


def _preset_row(table: Table, name: str, rows: Array) -> None:
    """Means, with their spread over the cases; lean and float at worst."""
    mean, spread, worst = rows.mean(0), rows.std(0), rows.max(0)
    before, after, long, off, off_after, wide, off_wide, off_wide_after = mean[:8]
    table.row(
        name,
        f"{before:.2f} → {after:.2f} ± {spread[1]:.2f}",
        float(long),
        f"{off:.1%} → {off_after:.1%} ± {spread[4]:.1%}",
        float(wide),
        f"{off_wide:.1%} → {off_wide_after:.1%} ± {spread[7]:.1%}",
        float(worst[8]),
        float(worst[9]),
        expected=[
            Expected("parts farther", 10 - float(long), 1.0),
            Expected("lean", float(worst[8]), 0.01, "deg"),
            Expected("float", float(worst[9]), 0.5, "cm"),
        ],
    )


def _figures(case: _Case, error_px: float, found: Proposal) -> Array:
    cm = 100 * Proportions.of(GIVEN).metres()
    before, after = (_off(case.person, body) for body in (GIVEN, found.body))
    nearer = (after <= before + 1e-9) | (after * cm < NEAR_CM)
    lean = max(
        _lean(found.body, found.keyposes[k]) - _lean(GIVEN, pose)
        for k, pose in case.keyposes.items()
    )
    floating = _floating(found.body, found.keyposes) - _floating(GIVEN, case.keyposes)
    return np.array(
        [
            error_px,
            found.error_px,
            nearer[::2].sum(),
            before[::2].mean(),
            after[::2].mean(),
            nearer[1::2].sum(),
            before[1::2].mean(),
            after[1::2].mean(),
            lean,
            100 * floating,
        ]
    )


def _off(person: Body, body: Body) -> Array:
    """(S,) by which share each size is off, the person as tall as the body."""
    true = with_height(person, height(body))
    return np.abs(np.log(Proportions.of(body).metres() / Proportions.of(true).metres()))


def _lean(body: Body, pose: Pose) -> float:
    """Degrees between the trunk's axis and up."""
    T = pose_transforms(Skeleton.of(body), pose)
    axis = T[body.index("neck"), :3, 3] - T[0, :3, 3]
    return float(np.degrees(np.arccos(axis @ UP / np.linalg.norm(axis))))


def _floating(body: Body, poses: Mapping[int, Pose]) -> float:
    """By how much the height of the lowest point varies, metres."""
    skeleton = Skeleton.of(body)
    mesh = BodyMesh.of(skeleton)
    return float(
        np.ptp([(mesh.posed(pose_transforms(skeleton, p)) @ UP).min() for p in poses.values()])
    )


def _case(motion: str, tall: float, seed: int) -> _Case:
    rng, person = np.random.default_rng(seed), scaled(GIVEN, tall)
    for name in LIMBS:
        long, wide = 1 + LIMB_SHARE * rng.choice([-1.0, 1.0], 2)
        person = resized(person, f"left_{name}", length_factor=long, thickness_factor=wide)
    truth, pictures, keys = _shown(motion, person, RenderSettings())
    keyposes = {k: _by_hand(person, truth.pose(k), tall, 100 * seed + k) for k in keys}
    return _Case(person, pictures, keyposes)


def _by_hand(person: Body, pose: Pose, tall: float, seed: int) -> Pose:
    """The given body with its joints where the person's are seen, turns out of the picture guessed,
    as far away as it looks as large."""
    rng = np.random.default_rng(seed)
    uv = _pixels(person, pose)
    uv = uv + rng.normal(0.0, POSED_PX, uv.shape)
    turns = exp_rotation(np.radians(rng.normal(0.0, TURNED_DEG, (len(GIVEN.parts), 3))))
    nearer = np.exp([0.0, 0.0, rng.normal(0.0, DEPTH_SHARE)]) / tall
    return _on(uv, Pose(pose.Rs_parent_part @ turns, pose.p_camera_root * nearer))
