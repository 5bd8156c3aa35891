"""Keypoints are lifted into space: joints of a known figure, whatever camera and film show it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bench.lift.poses import JOINTS as OF_POSES
from bench.lift.poses import own_motions
from keypose.tracker.errors import KeypointError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.blazepose import NAMES
from keypose.tracker.keypoints.keypoints import Keypoints, other_side
from keypose.tracker.keypoints.lifting import INPUTS, LIFTED, NETWORKS, Lifted, lifted
from keypose.tracker.keypoints.model_files import LIFTER, verified
from keypose.tracker.keypoints.runtimes import ONNX, fast_is_here, open_runtime

CAMERA = Camera.from_field_of_view(1280, 720, 1.2)
FRAMES_PER_SECOND = 30
COUNT = 60
AWAY_M = 4.5
UP = np.array([0.0, -1.0, 0.0])


def figure() -> Array:
    """Joints (60, 16, 3) of a person who squats, turned half aside, in the order of `LIFTED`,
    about the middle of the hips, x right, y down, z away."""
    joints, _, _ = own_motions(1, np.random.default_rng(21))
    names = [name.replace("foot_index", "toe") for name in LIFTED]
    order = [
        OF_POSES.index(
            name
            if name in OF_POSES
            else "_".join(reversed(name.split("_"))).replace("right", "r").replace("left", "l")
        )
        for name in names
    ]
    p = joints[:COUNT] - (joints[:COUNT, 1:2] + joints[:COUNT, 5:6]) / 2
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, 0, -s], [0, -1, 0], [-s, 0, -c]])  # towards the camera, half aside
    return np.asarray(p[:, order] @ turn.T, dtype=float)


def seen(p: Array, camera: Camera = CAMERA, turn: Array | None = None) -> Keypoints:
    """What a perfect network sees of it."""
    there = (p + np.array([0.0, 0.0, AWAY_M])) @ (np.eye(3) if turn is None else turn).T
    uv = np.full((len(p), len(NAMES), 2), np.nan)
    for k, name in enumerate(LIFTED):
        for each in ("left_ear", "right_ear") if name == "head" else (name,):
            if each in NAMES:
                uv[:, NAMES.index(each)] = camera.project(there[:, k])
    return Keypoints(0, NAMES, uv, np.isfinite(uv[..., 0]) * 1.0)


def times(count: int = COUNT) -> Array:
    return np.arange(count) / FRAMES_PER_SECOND


def size_m(p: Array) -> float:
    def way(a: str, b: str) -> Array:
        return np.linalg.norm(p[:, LIFTED.index(a)] - p[:, LIFTED.index(b)], axis=-1)

    leg = (
        sum(
            way(f"{s}_hip", f"{s}_knee") + way(f"{s}_knee", f"{s}_ankle") for s in ("left", "right")
        )
        / 2
    )
    shoulders = (p[:, LIFTED.index("left_shoulder")] + p[:, LIFTED.index("right_shoulder")]) / 2
    return float((leg + np.linalg.norm(shoulders, axis=-1)).mean())


def off_cm(found: Lifted, p: Array) -> Array:
    """How far joints are off, (N, 16)."""
    return np.asarray(np.linalg.norm(found.p_hips * size_m(p) - p, axis=2) * 100)


@pytest.fixture(scope="module")
def truth() -> Array:
    return figure()


@pytest.fixture(scope="module")
def squat(truth: Array) -> Lifted:
    return lifted(seen(truth), CAMERA, times(), UP)


def test_joints_of_a_known_figure_are_found_to_centimetres(truth: Array, squat: Lifted) -> None:
    assert squat.names == LIFTED
    assert squat.p_hips.shape == (COUNT, len(LIFTED), 3)
    assert squat.sigma.shape == (COUNT, len(LIFTED), 2)
    assert off_cm(squat, truth).mean() < 8.0


def test_most_errors_are_within_the_deviation_that_is_said(truth: Array, squat: Lifted) -> None:
    share = np.abs(squat.p_hips - truth / size_m(truth)) / squat.sigma[..., [0, 0, 1]]
    assert (share < 2).mean() > 0.8


def test_a_camera_that_is_turned_after_a_person_sees_the_same(truth: Array, squat: Lifted) -> None:
    c, s = np.cos(0.35), np.sin(0.35)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    aside = lifted(seen(truth, turn=turn), CAMERA, times(), UP)
    assert aside.p_hips @ turn == pytest.approx(squat.p_hips, abs=0.02)


def test_a_mirrored_film_gives_mirrored_joints(truth: Array, squat: Lifted) -> None:
    p = truth[:, [LIFTED.index(other_side(name, LIFTED)) for name in LIFTED]] * [-1, 1, 1]
    mirrored = lifted(seen(p), CAMERA, times(), UP)
    order = [LIFTED.index(other_side(name, LIFTED)) for name in LIFTED]
    assert mirrored.p_hips[:, order] * [-1, 1, 1] == pytest.approx(squat.p_hips, abs=1e-4)
    assert mirrored.sigma[:, order] == pytest.approx(squat.sigma, rel=1e-3)


@pytest.mark.parametrize("rate", [240.0, 60.0, 50.0, 12.0])
def test_films_of_any_rate_give_the_same_joints(truth: Array, squat: Lifted, rate: float) -> None:
    at = np.arange(0, times()[-1], 1 / rate)
    p = np.array([[np.interp(at, times(), truth[:, j, a]) for a in range(3)] for j in range(16)])
    p = p.transpose(2, 0, 1)
    found = lifted(seen(p), CAMERA, at, UP)
    middle = np.nonzero((at > 0.5) & (at < 1.4))[0]
    there = np.round(at[middle] * FRAMES_PER_SECOND).astype(int)
    near = np.abs(at[middle] - times()[there]) < 1e-6
    assert found.p_hips[middle[near]] == pytest.approx(squat.p_hips[there[near]], abs=0.03)


def test_a_lens_that_bends_lines_is_allowed_for(truth: Array, squat: Lifted) -> None:
    bent = CAMERA.model_copy(update={"distortion": (-0.2, 0.05, 0.001, 0.0, 0.0)})
    found = lifted(seen(truth, bent), bent, times(), UP)
    assert found.p_hips == pytest.approx(squat.p_hips, abs=1e-3)


def test_a_telephoto_camera_sees_the_figure_too(truth: Array) -> None:
    long = Camera.from_field_of_view(1280, 720, 0.1)
    tele = long.model_copy(update={"projection": "telephoto", "telephoto_distance_m": 40.0})
    found = lifted(seen(truth, tele), tele, times(), UP)
    assert off_cm(found, truth).mean() < 10.0


@pytest.mark.parametrize("count", [1, 2, 5])
def test_a_film_shorter_than_the_window_is_lifted(truth: Array, count: int) -> None:
    found = lifted(seen(truth[:count]), CAMERA, times(count), UP)
    assert len(found) == count
    assert off_cm(found, truth[:count]).mean() < 15.0


def test_no_frames_give_no_joints(truth: Array) -> None:
    assert len(lifted(seen(truth[:0]), CAMERA, times(0))) == 0


def test_frames_that_show_nobody_have_no_joints_and_their_neighbours_do(truth: Array) -> None:
    full = seen(truth)
    uv, visibility = full.uv.copy(), full.visibility.copy()
    uv[20:30], visibility[20:30] = np.nan, 0.0
    found = lifted(replace(full, uv=uv, visibility=visibility), CAMERA, times(), UP)
    unknown = np.isnan(found.p_hips).all(axis=(1, 2))
    assert unknown.tolist() == [20 <= n < 30 for n in range(COUNT)]
    assert np.isfinite(found.sigma[~unknown]).all()
    assert off_cm(found, truth)[~unknown].mean() < 10.0


def test_frames_that_are_missing_here_and_there_change_little(truth: Array, squat: Lifted) -> None:
    full = seen(truth)
    visibility = full.visibility.copy()
    visibility[np.random.default_rng(2).random(COUNT) < 0.3] = 0.0
    found = lifted(replace(full, visibility=visibility), CAMERA, times(), UP)
    known = np.nonzero(visibility.any(axis=1))[0][3:-3]
    assert found.p_hips[known] == pytest.approx(squat.p_hips[known], abs=0.03)


@pytest.mark.parametrize("as_hidden", ["unseen", "low visibility"])
def test_what_is_hidden_is_guessed_and_less_sure(
    truth: Array, squat: Lifted, as_hidden: str
) -> None:
    full = seen(truth)
    uv, visibility = full.uv.copy(), full.visibility.copy()
    for name in ("left_elbow", "left_wrist"):
        k = NAMES.index(name)
        visibility[:, k] = 0.05
        uv[:, k] = np.nan if as_hidden == "unseen" else 3.0
        if as_hidden == "unseen":
            visibility[:, k] = 0.0
    found = lifted(replace(full, uv=uv, visibility=visibility), CAMERA, times(), UP)
    wrist, knee = LIFTED.index("left_wrist"), LIFTED.index("left_knee")
    assert np.isfinite(found.p_hips).all()
    assert found.sigma[:, wrist].mean() > 2 * squat.sigma[:, wrist].mean()
    assert found.sigma[:, knee].mean() < 1.5 * squat.sigma[:, knee].mean()


def test_hips_that_are_hidden_for_a_moment_are_bridged(truth: Array) -> None:
    full = seen(truth)
    visibility = full.visibility.copy()
    visibility[25:28, NAMES.index("right_hip")] = 0.0
    found = lifted(replace(full, visibility=visibility), CAMERA, times(), UP)
    assert off_cm(found, truth)[25:28].mean() < 12.0


def test_what_is_far_from_any_sight_of_the_hips_is_not_lifted_and_harms_nothing(
    truth: Array, squat: Lifted
) -> None:
    full = seen(truth)
    visibility = full.visibility.copy()
    visibility[30:, [NAMES.index("left_hip"), NAMES.index("right_hip")]] = 0.0
    found = lifted(replace(full, visibility=visibility), CAMERA, times(), UP)
    assert np.isnan(found.p_hips[45:]).all()
    assert found.p_hips[:14] == pytest.approx(squat.p_hips[:14], abs=0.02)
    assert off_cm(found, truth)[:40].mean() < 12.0


def test_coco_keypoints_without_toes_are_lifted(truth: Array) -> None:
    full = seen(truth)
    kept = [n for n, name in enumerate(NAMES) if "foot" not in name and "heel" not in name]
    names = tuple(NAMES[n] for n in kept)
    few = Keypoints(0, names, full.uv[:, kept], full.visibility[:, kept])
    assert off_cm(lifted(few, CAMERA, times(), UP), truth).mean() < 10.0


def test_up_may_differ_from_frame_to_frame(truth: Array, squat: Lifted) -> None:
    found = lifted(seen(truth), CAMERA, times(), np.tile(UP * 3, (COUNT, 1)))
    assert np.array_equal(found.p_hips, squat.p_hips)


@pytest.mark.parametrize("nothing", [0.0, np.nan])
def test_up_may_be_unknown_in_some_frames(truth: Array, squat: Lifted, nothing: float) -> None:
    ups = np.tile(UP, (COUNT, 1))
    ups[10:] = nothing
    found = lifted(seen(truth), CAMERA, times(), ups)
    unknown = lifted(seen(truth), CAMERA, times())
    assert found.p_hips[:10] == pytest.approx(squat.p_hips[:10], abs=1e-5)
    assert found.p_hips[10:] == pytest.approx(unknown.p_hips[10:], abs=1e-5)


def test_keypoints_that_are_no_persons_are_refused() -> None:
    dog = Keypoints(0, ("nose", "tail"), np.zeros((3, 2, 2)), np.ones((3, 2)))
    with pytest.raises(KeypointError, match=r"have no left_shoulder.*only a person's"):
        lifted(dog, CAMERA, times(3))


@pytest.mark.parametrize(
    "wrong", [[0.0, 0.1], [0.0, 0.2, 0.1], [0.0, 0.0, 0.1], [0.0, np.nan, 1.0]]
)
def test_times_that_do_not_rise_with_the_frames_are_refused(
    truth: Array, wrong: list[float]
) -> None:
    with pytest.raises(KeypointError, match="Times of 3 frames"):
        lifted(seen(truth[:3]), CAMERA, wrong)


def test_a_motion_that_nobody_makes_is_less_sure(truth: Array, squat: Lifted) -> None:
    rng = np.random.default_rng(5)
    limbs = [n for n, name in enumerate(LIFTED) if "hip" not in name and "shoulder" not in name]
    torn = truth.copy()
    torn[:, limbs] += rng.normal(0, 0.4, (COUNT, len(limbs), 3))
    found = lifted(seen(torn), CAMERA, times(), UP)
    assert np.median(found.sigma) > 1.3 * np.median(squat.sigma)


def test_the_network_answers_a_known_input_with_known_numbers() -> None:
    x = np.sin(np.arange(INPUTS, dtype=float))[:, None, None].astype(np.float32)
    found = open_runtime(LIFTER.file, verified(LIFTER), NETWORKS, fast=False).run(x)
    known = ([0.2239726, -0.2522525, -3.359458], [-0.0211648, -0.2021260, -5.024579])
    for output, numbers in zip(found, known, strict=True):
        assert output[0, [0, 2, 80], 0, 0] == pytest.approx(numbers, abs=1e-5)


@pytest.mark.skipif(not fast_is_here(ONNX), reason="ONNX Runtime is not installed")
def test_opencv_and_onnx_runtime_agree() -> None:
    x = np.random.default_rng(0).normal(size=(INPUTS, 7, 1)).astype(np.float32)
    content = verified(LIFTER)
    by = [open_runtime(LIFTER.file, content, NETWORKS, fast=fast).run(x) for fast in (False, True)]
    for ours, theirs in zip(*by, strict=True):
        assert ours == pytest.approx(theirs, rel=1e-5, abs=1e-5)
