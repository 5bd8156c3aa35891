"""Lengths that one film leaves open are found by two, and the height where it was measured."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
import pytest

from bench.sequences import video_of
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.modify import height, resized, scaled
from keypose.tracker.body.pose import Pose, joint_positions, moved, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.films.cameras import joints_of_pose
from keypose.tracker.films.mend import SeenInFilm
from keypose.tracker.fitting.sizes import SizesFitted, fit_sizes
from keypose.tracker.fitting.sizes.beside import seen_beside
from keypose.tracker.fitting.sizes.proportions import Proportions
from keypose.tracker.fitting.sizes.shared import (
    Shared,
    SharedFit,
    _pose_jacobian,
    _size_jacobian,
)
from keypose.tracker.geometry.rotations import Array, rotation_from_euler, transform
from keypose.tracker.solver.fit_joints import fit_picture
from tests.rendering.motions import stride
from tests.rendering.render import render
from tests.rendering.scenes import camera
from tests.tracker.fitting import test_shared_sizes as shared_cases

GIVEN = preset("adult_male")
PROPORTIONS = Proportions.of(GIVEN)
CAMERA = camera()
KEYS = (8, 30, 55, 85)
LIMBS = {"upper_arm": 1.08, "forearm": 0.91, "thigh": 1.05, "shin": 0.95}
TALLER = 1.06
SHAKES = 0.004
"""Of a keypoint, a share of the body's height."""


@dataclass(frozen=True, eq=False)
class Case:
    """A person, the given body posed over one film of them, and what another shows."""

    person: Body
    pictures: Array
    keyposes: dict[int, Pose]
    films: dict[int, list[SeenInFilm]]

    def fitted(self, films: bool = True, *, grey: bool = False, taller: float = 1.0) -> SizesFitted:
        pictures = np.full_like(self.pictures, 120) if grey else self.pictures
        video = video_of(len(pictures), lambda number: pictures[number])
        beside = self.films if films else {}
        measured = taller if taller != 1.0 else None
        return fit_sizes(video, CAMERA, GIVEN, self.keyposes, films=beside, measured=measured)

    def off_percent(self, fitted: SizesFitted) -> Array:
        """(4,) of the limbs' lengths, beside how they are on average."""
        proposal = fitted.with_poses or fitted.alone
        assert proposal is not None
        off = _logs(proposal.body) - _logs(self.person)
        return 100 * np.abs(off - off.mean())


def _logs(body: Body) -> Array:
    metres = Proportions.of(body).metres()[::2]
    return np.log([metres[PROPORTIONS.names.index(name)] for name in LIMBS])


def _aside(middle: Array) -> Array:
    R = rotation_from_euler(0.05, np.radians(65.0), 0.08)
    return transform(R, middle - R @ middle + np.array([0.2, 0.1, 0.3]))


@cache
def case(taller: float = 1.0, seed: int = 0) -> Case:
    """taller: than the body that is posed, at whose size the other film's camera was placed."""
    rng, person = np.random.default_rng(seed), GIVEN
    for name, ratio in LIMBS.items():
        person = resized(person, f"left_{name}", length_factor=ratio)
    person = scaled(person, taller * height(GIVEN) / height(person))
    skeleton = Skeleton.of(person)
    whole = stride(skeleton)
    truth = Trajectory(
        0, whole.Rs_parent_part[list(KEYS)], taller * whole.ps_camera_root[list(KEYS)]
    )
    T = _aside(truth.ps_camera_root.mean(axis=0))
    taken = T.copy()
    taken[:3, 3] /= taller
    keyposes, films = {}, {}
    for row in range(len(KEYS)):
        pose = truth.pose(row)
        near = Pose(pose.Rs_parent_part, pose.p_camera_root / taller)
        uv = CAMERA.project(joint_positions(skeleton, pose_transforms(skeleton, pose)))
        places = shared_places(GIVEN)
        keyposes[row] = fit_picture(GIVEN, CAMERA, places, uv, np.ones(len(uv)), [near], near).pose
        p = joints_of_pose(skeleton, pose) @ T[:3, :3].T + T[:3, 3]
        tall_px = CAMERA.fy * height(person) / float(p[:, 2].mean())
        seen = CAMERA.project(p) + rng.normal(0.0, SHAKES * tall_px, (len(p), 2))
        films[row] = [SeenInFilm(CAMERA, taken, seen, np.ones(len(p)))]
    return Case(person, render(skeleton, truth, CAMERA), keyposes, films)


def shared_places(body: Body) -> list[tuple[tuple[int, tuple[float, float, float]], ...]]:
    """The joints and landmarks of a body."""
    marks = [(i, p) for i, part in enumerate(body.parts) for p in part.landmarks.values()]
    return [((i, (0.0, 0.0, 0.0)),) for i in range(len(body.parts))] + [(mark,) for mark in marks]


# --- how what another film sees follows from what is unknown


def _with_film() -> tuple[SharedFit, Shared]:
    made = shared_cases.fit()
    joints = [joints_of_pose(Skeleton.of(GIVEN), pose) for pose in made.posed]
    T = _aside(np.array([0.0, 0.0, 4.0]))
    films = [
        [SeenInFilm(CAMERA, T, CAMERA.project(p @ T[:3, :3].T + T[:3, 3]), np.ones(len(p)))]
        for p in joints
    ]
    share = np.append(made.share, 0.1)
    free = np.append(made.free, True)
    beside = seen_beside(made.proportions, made.posed, films)
    return (
        replace(made, free=free, usual=share, share=share, beside=beside),
        Shared(np.zeros(len(free)), made.posed),
    )


def test_slopes_in_another_film_agree_with_differences() -> None:
    made, start = _with_film()
    rng = np.random.default_rng(5)
    shared = made.with_step(start, 0.03 * rng.normal(size=len(made.free)) * made.free)
    ((seen,), *_) = made.beside
    there = made.pixels(shared, 0, seen.residuals, seen.film)
    J = _pose_jacobian(made, shared, 0, seen.residuals, seen.film)
    skeleton = made.proportions.skeleton
    for d in rng.choice(skeleton.dof_count, 8, replace=False):
        step = np.zeros(skeleton.dof_count)
        step[d] = 1e-5
        poses = (moved(skeleton, shared.poses[0], step), *shared.poses[1:])
        beside = made.pixels(replace(shared, poses=poses), 0, seen.residuals, seen.film)
        slope = seen.residuals.along(beside - there) / 1e-5
        np.testing.assert_allclose(J[:, d], slope, atol=0.02 * np.abs(slope).max() + 1e-3)
    S = _size_jacobian(made, shared, 0, seen.residuals, there, seen.film)
    assert np.abs(S[:, -1]).max() > 10.0, "farther cameras see the body elsewhere"


def test_all_larger_by_one_share_looks_the_same_in_every_film() -> None:
    made, start = _with_film()
    larger = np.zeros(len(made.free))
    larger[: PROPORTIONS.count] = larger[-2:] = np.log(1.1)
    shared = made.with_step(start, larger)
    for k in range(shared_cases.POSES):
        for seen in made.beside[k]:
            before, after = (
                made.pixels(at, k, seen.residuals, seen.film) for at in (start, shared)
            )
            np.testing.assert_allclose(after, before, atol=1e-6)


# --- what is found


def test_two_films_find_proportions_nearer_than_one() -> None:
    shown = case()
    one, two = (shown.off_percent(shown.fitted(films)).mean() for films in (False, True))
    assert two < 0.75 * one
    assert two < 2.0


def test_lengths_are_found_by_another_film_where_no_outline_is_seen_and_widths_are_not() -> None:
    shown = case()
    fitted = shown.fitted(grey=True)
    assert shown.off_percent(fitted).mean() < 3.0
    proposal = fitted.with_poses
    assert proposal is not None
    assert {what for _, what, *_ in proposal.changes} == {"length"}
    assert shown.fitted(films=False, grey=True).with_poses is None


def test_films_that_show_somebody_else_change_nothing() -> None:
    shown = case()
    elsewhere = {
        frame: [replace(seen, uv=seen.uv + 400.0) for seen in films]
        for frame, films in shown.films.items()
    }
    without, with_others = (
        replace(shown, films=films).fitted() for films in (dict[int, list[SeenInFilm]](), elsewhere)
    )
    assert with_others.message == without.message
    assert with_others.note == ""
    assert without.with_poses is not None
    assert with_others.with_poses is not None
    assert without.with_poses.body == with_others.with_poses.body


def test_without_a_measured_distance_the_films_are_said_to_show_no_height() -> None:
    fitted = case().fitted()
    assert fitted.note == (
        "Proportions are from 2 films. They do not show how tall the person is: set the height if "
        "you know it."
    )
    proposal = fitted.with_poses
    assert proposal is not None
    assert proposal.larger == 1.0
    assert height(proposal.body) == pytest.approx(height(GIVEN), rel=0.02)


def test_a_measured_distance_of_cameras_shows_the_height_and_how_sure_it_is() -> None:
    shown = case(TALLER)
    fitted = shown.fitted(taller=TALLER)
    proposal = fitted.with_poses
    assert proposal is not None
    tall_cm, words = 100 * height(proposal.body), fitted.note.removesuffix(" cm.").split()
    assert words[-2] == "±"
    assert float(words[-3]) == pytest.approx(tall_cm, abs=0.51)
    assert abs(tall_cm - 100 * height(shown.person)) < float(words[-1]) < 5.0
    assert proposal.larger == pytest.approx(TALLER, rel=0.02)
    assert proposal.apart == pytest.approx(TALLER, rel=1e-6)


def test_what_is_larger_is_seen_in_the_first_film_where_it_was_posed() -> None:
    shown = case(TALLER)
    proposal = shown.fitted(taller=TALLER).with_poses
    assert proposal is not None
    before, after = (
        _pixels(body, poses)
        for body, poses in ((GIVEN, shown.keyposes), (proposal.body, proposal.keyposes))
    )
    assert np.linalg.norm(after - before, axis=-1).mean() < 3.0
    for row, pose in proposal.keyposes.items():
        ratio = pose.p_camera_root[2] / shown.keyposes[row].p_camera_root[2]
        assert ratio == pytest.approx(TALLER, abs=0.04)


def _pixels(body: Body, poses: dict[int, Pose] | Sequence[Pose]) -> Array:
    skeleton = Skeleton.of(body)
    every = poses.values() if isinstance(poses, dict) else poses
    return np.stack(
        [CAMERA.project(joint_positions(skeleton, pose_transforms(skeleton, p))) for p in every]
    )
