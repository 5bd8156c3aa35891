"""A film tells how its camera turned and zoomed; where it does not, that is said."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.camera_motion import CameraMotion, find_camera_motion
from keypose.tracker.errors import CameraError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import transform
from keypose.tracker.session.camera_motion import CameraKeyframe, CameraPiece, path_through
from keypose.tracker.session.camera_motion import CameraMotion as SessionMotion
from tests.tracker.camera_cases import (
    SMALL,
    Grey,
    film,
    noisy,
    off_deg,
    planes,
    read_by_rows,
    rendered,
    texture,
    turned,
    wandering,
    with_mover,
)

FRAMES = 40
ROTATIONS, ZOOMS = wandering(FRAMES)


def found_in(pictures: list[Grey], camera: Camera = SMALL, **given: object) -> CameraMotion:
    return find_camera_motion(pictures, camera, len(pictures), **given)  # type: ignore[arg-type]


def kinds(found: CameraMotion) -> set[str]:
    return {finding.kind for finding in found.findings}


@pytest.fixture(scope="module")
def wandered() -> list[Grey]:
    return film(SMALL, ROTATIONS, ZOOMS)


def test_a_pan_there_and_back_with_a_zoom_is_found(wandered: list[Grey]) -> None:
    found = found_in(wandered)
    assert found.kind == "turns"
    assert found.path is not None
    assert found.known.all()
    assert off_deg(found.path.Ts_camera_world, ROTATIONS).max() < 0.05
    assert np.abs(found.path.zoom / ZOOMS - 1).max() < 0.002
    assert (found.path.Ts_camera_world[0] == np.eye(4)).all()
    assert not found.path.moves
    assert found.findings == ()


@pytest.mark.parametrize("masked", [True, False])
def test_something_that_moves_by_itself_does_not_lead_astray(
    wandered: list[Grey], masked: bool
) -> None:
    pictures, where = with_mover(wandered)
    background = (lambda frame: where[frame] == 0) if masked else (lambda frame: None)
    found = found_in(pictures, background=background)
    assert found.path is not None
    assert off_deg(found.path.Ts_camera_world, ROTATIONS).max() < 0.1
    uv, good = found.points.of(FRAMES // 2)
    column, row = np.rint(uv.T).astype(int)
    inside = where[FRAMES // 2][row, column] > 0
    assert not inside.any() if masked else not (good & inside).any()


LENSES = {
    "distorted": {"distortion": (-0.25, 0.06, 0.001, -0.001, 0.0)},
    "off its middle": {"cx": 140.0, "cy": 100.0, "fy": 470.0},
    "telephoto": {"projection": "telephoto", "telephoto_distance_m": 10.0},
    "upright": {"width": 180, "height": 320, "cx": 89.5, "cy": 159.5},
    "large": {"width": 1280, "height": 720, "fx": 1824.0, "fy": 1824.0, "cx": 639.5, "cy": 359.5},
}


@pytest.mark.parametrize("name", LENSES)
def test_a_turn_is_found_through_any_lens(name: str) -> None:
    camera = Camera(**{**SMALL.model_dump(), **LENSES[name]})
    plain = camera.model_copy(update={"projection": "perspective", "telephoto_distance_m": None})
    rotations = ROTATIONS[:12]
    found = found_in(film(plain, rotations), camera)
    assert found.path is not None
    assert off_deg(found.path.Ts_camera_world, rotations).max() < 0.05
    assert not found.path.zooms


@pytest.mark.parametrize("mover", [False, True])
def test_a_camera_that_stands_still_is_static_to_the_last_digit(mover: bool) -> None:
    pictures = film(SMALL, [np.eye(3)] * 30, noise=4.0)
    found = found_in(with_mover(pictures)[0] if mover else pictures)
    assert found.kind == "static"
    assert found.path is None
    assert found.known.all()
    assert found.findings == ()


def steps(count: int) -> list[NDArray[np.float64]]:
    return [np.array([0.03 * frame, 0.0, 0.0]) for frame in range(count)]


def test_a_camera_that_goes_sideways_moves() -> None:
    pictures = [planes(SMALL, np.eye(3), p) for p in steps(24)]
    assert found_in(pictures).kind == "moves"


def test_before_the_same_scene_a_camera_that_only_turns_turns() -> None:
    rotations = [turned(0.4 * frame) for frame in range(24)]
    found = found_in([planes(SMALL, R, np.zeros(3)) for R in rotations])
    assert found.kind == "turns"
    assert found.path is not None
    assert off_deg(found.path.Ts_camera_world, rotations).max() < 0.05


def test_the_kind_that_a_person_sets_counts(wandered: list[Grey]) -> None:
    assert found_in(wandered[:8], fixed="static").path is None
    still = found_in([wandered[0]] * 8, fixed="turns")
    assert still.path is not None
    assert off_deg(still.path.Ts_camera_world, [np.eye(3)] * 8).max() < 0.01


def flicker(frame: int) -> Grey:
    """Water, seen near: nothing stays what it was."""
    return texture(100 + frame, 180, 320)


def blinded(pictures: list[Grey]) -> list[Grey | None]:
    return [np.zeros_like(p) if 15 <= k < 21 else p for k, p in enumerate(pictures)]


BAD: dict[str, tuple[Callable[[], list[Grey | None]], set[str]]] = {
    "nothing": (lambda: [], set()),
    "one frame": (lambda: [texture(0, 180, 320)], set()),
    "two frames": (lambda: [texture(0, 180, 320)] * 2, set()),
    "black": (lambda: [np.zeros((180, 320), np.uint8)] * 12, {"no_texture"}),
    "two black": (lambda: [np.zeros((180, 320), np.uint8)] * 2, {"no_texture"}),
    "a wall": (
        lambda: [
            noisy(np.full((180, 320), 120, np.uint8), np.random.default_rng(k)) for k in range(12)
        ],
        {"no_texture"},
    ),
    "noise": (
        lambda: [
            np.random.default_rng(k).integers(0, 256, (180, 320)).astype(np.uint8)
            for k in range(12)
        ],
        {"not_rigid"},
    ),
    "water": (lambda: [flicker(frame) for frame in range(20)], {"not_rigid"}),
    "not readable": (lambda: [None] * 6, {"no_picture"}),
}


@pytest.mark.parametrize("name", BAD)
def test_of_bad_pictures_nothing_is_invented(name: str) -> None:
    make, expected = BAD[name]
    pictures = make()
    found = find_camera_motion(pictures, SMALL, len(pictures))
    assert found.kind == "static"
    assert kinds(found) == expected
    assert len(found.known) == len(pictures)
    assert found.known[1:].any() == (name == "two frames")


def test_where_the_body_fills_the_picture_that_is_said(wandered: list[Grey]) -> None:
    narrow = np.zeros((180, 320), bool)
    narrow[:8] = True
    found = found_in(wandered[:12], background=lambda frame: narrow)
    assert kinds(found) == {"body_fills"}
    assert not found.known.any()


def test_a_cut_is_told_and_both_scenes_are_followed() -> None:
    rotations = [turned(0.3 * k) for k in range(20)]
    pictures = [rendered(SMALL, R, seed=0 if k < 10 else 5) for k, R in enumerate(rotations)]
    found = found_in(pictures)
    cuts = [finding.first_frame for finding in found.findings if finding.kind == "cut"]
    assert cuts == [10]
    assert found.path is not None
    R = found.path.Ts_camera_world[:, :3, :3]
    one, other = R[9] @ R[0].T, R[19] @ R[12].T
    assert off_deg(one[None], [turned(2.7)]).max() < 0.05
    assert off_deg(other[None], [turned(2.1)]).max() < 0.05


def test_a_scene_that_comes_back_is_known_again(wandered: list[Grey]) -> None:
    found = find_camera_motion(blinded(wandered), SMALL, FRAMES)
    assert kinds(found) == {"no_texture"}
    assert found.path is not None
    assert list(np.flatnonzero(~found.known)) == list(range(15, 21))
    assert off_deg(found.path.Ts_camera_world, ROTATIONS)[found.known].max() < 0.1


def test_frames_that_cannot_be_read_are_bridged(wandered: list[Grey]) -> None:
    pictures = [None if k % 9 == 4 else p for k, p in enumerate(wandered)]
    found = find_camera_motion(pictures, SMALL, FRAMES)
    assert found.path is not None
    assert (found.known == [p is not None for p in pictures]).all()
    assert np.isnan(found.error_px[4])
    assert off_deg(found.path.Ts_camera_world, ROTATIONS).max() < 0.3


def test_a_picture_that_becomes_brighter_does_not_matter(wandered: list[Grey]) -> None:
    gain = 1 + 0.25 * np.sin(np.arange(FRAMES) * 0.2)
    pictures = [
        np.clip(p * g, 0, 255).astype(np.uint8) for p, g in zip(wandered, gain, strict=True)
    ]
    found = found_in(pictures)
    assert found.path is not None
    assert off_deg(found.path.Ts_camera_world, ROTATIONS).max() < 0.1


FADES: dict[str, tuple[int, Callable[[int], float], list[int]]] = {
    "five black frames at first": (0, lambda frame: float(frame >= 5), [0, 4]),
    "a fade-in": (0, lambda frame: frame / 15, [0, 6]),
    "a fade-in from white": (255, lambda frame: frame / 15, [0, 6]),
    "a fade-out": (0, lambda frame: (FRAMES - 1 - frame) / 15, [FRAMES - 7, FRAMES - 1]),
    "a dip to black": (0, lambda frame: abs(frame - 20) / 8, [16, 24]),
    "flat grey in the middle": (128, lambda frame: float(not 15 <= frame < 25), [15, 24]),
}
"""Towards which grey level, the picture's own weight at a frame, and where it may be lost."""


@pytest.mark.parametrize("name", FADES)
@pytest.mark.parametrize("stands", [True, False], ids=["stands still", "turns"])
def test_a_fade_is_not_taken_for_a_background_that_moves(
    wandered: list[Grey], name: str, stands: bool
) -> None:
    toward, weight, (first, last) = FADES[name]
    shown = [wandered[0]] * FRAMES if stands else wandered
    faded = [
        np.asarray(np.rint(toward + (p.astype(float) - toward) * min(1.0, weight(k))), np.uint8)
        for k, p in enumerate(shown)
    ]
    found = found_in(faded)
    assert found.kind == ("static" if stands else "turns")
    assert kinds(found) <= {"no_texture"}
    assert {*np.flatnonzero(~found.known)} <= {*range(first, last + 1)}
    for finding in found.findings:
        assert first <= finding.first_frame <= finding.last_frame <= last


def test_a_pan_tells_the_focal_length() -> None:
    rotations = [turned(0.7 * k, 0.1 * k) for k in range(24)]
    wrong = SMALL.model_copy(update={"fx": SMALL.fx * 1.2, "fy": SMALL.fy * 1.2})
    found = found_in(film(SMALL, rotations), wrong)
    assert found.kind == "turns"
    assert found.focal is not None
    assert abs(found.focal.scale * 1.2 - 1) < 4 * found.focal.sigma < 0.1
    assert found_in(film(SMALL, rotations[:2] * 5), wrong).focal is None


def test_a_rolling_shutter_is_told_and_does_not_roll_the_camera() -> None:
    def at(time: float) -> NDArray[np.float64]:
        return turned(5 * np.sin(time * 0.15))

    found = found_in(read_by_rows(SMALL, at, 45, 0.6))
    (finding,) = found.findings
    assert finding.kind == "rolling_shutter"
    assert abs(finding.amount - 0.6) < 0.12
    assert found.path is not None
    assert off_deg(found.path.Ts_camera_world, [at(k) for k in range(45)]).max() < 0.06


@pytest.mark.parametrize("blind", [True, False])
def test_what_nothing_ties_together_is_told_and_corrected_by_itself(blind: bool) -> None:
    far = turned(20.0)  # a jump that no picture shows
    true = [R if k < 18 else far @ R for k, R in enumerate(ROTATIONS)]
    pictures = film(SMALL, true, ZOOMS)
    found = find_camera_motion(blinded(pictures) if blind else pictures, SMALL, FRAMES)
    assert found.path is not None
    assert found.pieces == (0, 15 if blind else 18)
    pieces = tuple(CameraPiece(first_frame=first) for first in found.pieces)
    motion = SessionMotion.of("turns", found.path, found.error_px, pieces=pieces)
    keys = tuple(CameraKeyframe.of(k, transform(true[k], np.zeros(3)), ZOOMS[k]) for k in (25, 38))
    helped = path_through(motion, keys)
    before, after = (off_deg(path.Ts_camera_world, true) for path in (found.path, helped))
    assert before[21:].min() > 10
    assert after[found.known].max() < 0.1


def test_a_gap_after_which_the_picture_is_seen_again_ties_together(wandered: list[Grey]) -> None:
    assert find_camera_motion(blinded(wandered), SMALL, FRAMES).pieces == (0,)


def test_work_can_be_cancelled_and_says_how_far_it_is(wandered: list[Grey]) -> None:
    told: list[tuple[int, int]] = []

    def progress(done: int, expected: int) -> None:
        told.append((done, expected))
        if done == 3:
            raise InterruptedError

    with pytest.raises(InterruptedError):
        find_camera_motion(wandered, SMALL, FRAMES, progress=progress)
    assert told == [(1, FRAMES), (2, FRAMES), (3, FRAMES)]


@pytest.mark.parametrize(("width", "height"), [(2, 2), (17, 31), (64, 48), (900, 24)])
def test_pictures_of_any_size_are_looked_at(width: int, height: int) -> None:
    camera, around = Camera.guess(width, height), texture(3)
    pictures = [around[90 : 90 + height, k : k + width].copy() for k in range(8)]
    found = found_in(pictures, camera)
    assert len(found.known) == 8
    assert (found.kind == "turns") == (width > 17)


def test_pictures_of_another_size_are_refused(wandered: list[Grey]) -> None:
    with pytest.raises(CameraError, match="320×180"):
        found_in([wandered[0][:100]])


def test_something_large_that_no_mask_covers_is_reported(wandered: list[Grey]) -> None:
    pictures = [picture.copy() for picture in wandered]
    for frame, picture in enumerate(pictures):
        left = 20 + round(8 * np.sin(0.5 * frame))
        picture[20:, left : left + 250] = texture(7)[:160, :250]
    assert "not_rigid" in kinds(found_in(pictures))


def test_the_same_film_gives_the_same_path(wandered: list[Grey]) -> None:
    one, other = (found_in(wandered[:10]) for _ in range(2))
    assert one.path is not None
    assert other.path is not None
    assert (one.path.Ts_camera_world == other.path.Ts_camera_world).all()
