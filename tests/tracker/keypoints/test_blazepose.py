"""The network: it finds what was marked, the same every time, and reads no other file."""

from __future__ import annotations

import hashlib
import zlib
from dataclasses import dataclass, replace
from pathlib import Path

import cv2
import numpy as np
import pytest

from keypose.tracker.errors import KeypointError
from keypose.tracker.keypoints import model_files, runtimes
from keypose.tracker.keypoints.blazepose import NAMES, SIDE, BlazePose, Seen
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.model_files import FULL, HEAVY, Model, verified
from keypose.tracker.keypoints.person_mask import FULL_LEVEL, PersonMask
from keypose.tracker.keypoints.region import Region
from keypose.tracker.keypoints.runtimes import TFLITE, fast_is_here
from tests.tracker.keypoints import keypoint_cases as cases

DISC = 40
"""Radius of the made-up person, pixels of the square."""


@pytest.fixture(scope="module")
def network() -> BlazePose:
    return BlazePose.open(fast=False)


def first_picture() -> np.ndarray:
    with cases.balance() as video:
        return video.frame(0)


def looked_at(network: BlazePose, picture: np.ndarray, region: Region | None = None) -> Seen:
    height, width = picture.shape[:2]
    region = region or Region.of_box(cases.BOX, width, height)
    for _ in range(3):
        seen = network.infer(picture, region)
        region = seen.next
    return seen


def test_the_names_are_those_of_the_network_and_hold_every_joint() -> None:
    assert len(set(NAMES)) == 33
    assert set(JOINTS) < set(NAMES)
    assert (NAMES[0], NAMES[11], NAMES[24], NAMES[32]) == (
        *("nose", "left_shoulder", "right_hip", "right_foot_index"),
    )


def test_marked_joints_are_found_to_a_few_hundredths_of_the_mans_height(network: BlazePose) -> None:
    seen = looked_at(network, first_picture())
    marked = cases.marks()[0]
    height = np.ptp([uv[1] for uv in marked.values()])
    apart = [
        np.hypot(*(seen.uv[NAMES.index(joint)] - marked[joint]))
        for joint in JOINTS
        if joint in marked
    ]
    assert len(apart) >= 10
    assert np.median(apart) < 0.02 * height
    assert seen.presence > 0.9


def test_metres_are_about_the_hips_and_as_large_as_a_man(network: BlazePose) -> None:
    seen = looked_at(network, first_picture())
    p = dict(zip(NAMES, seen.p_hips, strict=True))
    assert np.isfinite(seen.p_hips).all()
    assert (p["left_hip"] + p["right_hip"]) / 2 == pytest.approx([0, 0, 0], abs=0.02)
    assert p["nose"][1] < p["left_hip"][1] < p["left_ankle"][1]
    assert 1.2 < np.ptp(seen.p_hips[:, 1]) < 2.0


def test_the_same_picture_gives_the_same_numbers(network: BlazePose) -> None:
    picture = first_picture()
    one, other = looked_at(network, picture), looked_at(BlazePose.open(fast=False), picture)
    for name in ("uv", "visibility", "p_hips"):
        assert np.array_equal(getattr(one, name), getattr(other, name))
    assert one.next == other.next


def test_the_number_of_threads_is_as_before(network: BlazePose) -> None:
    before = cv2.getNumThreads()
    looked_at(network, first_picture())
    assert cv2.getNumThreads() == before


@pytest.mark.parametrize("quarter_turns", [1, 2, 3])
def test_a_turned_picture_gives_turned_keypoints(network: BlazePose, quarter_turns: int) -> None:
    picture = first_picture()
    seen = looked_at(network, picture)
    turned = np.ascontiguousarray(np.rot90(picture, -quarter_turns))
    A = np.array([[0, -1], [1, 0]])  # a quarter turn clockwise, y down
    size = np.array([picture.shape[1], picture.shape[0]])

    def there(uv: np.ndarray) -> np.ndarray:
        width, height = size
        for _ in range(quarter_turns):
            uv = uv @ A.T + [height - 1, 0]
            width, height = height, width
        return uv

    where = there(np.array([seen.next.x, seen.next.y]))
    turn = seen.next.turn_rad + quarter_turns * np.pi / 2
    again = network.infer(turned, Region(*where, seen.next.side, turn))
    straight = network.infer(picture, seen.next)
    assert again.uv == pytest.approx(there(straight.uv), abs=0.5)
    up = np.linalg.matrix_power(A, quarter_turns)
    assert again.p_hips[:, :2] == pytest.approx(straight.p_hips[:, :2] @ up.T, abs=0.02)
    assert again.p_hips[:, 2] == pytest.approx(straight.p_hips[:, 2], abs=0.02)


def test_in_a_mirror_the_same_is_seen_with_left_still_left(network: BlazePose) -> None:
    picture = first_picture()
    region = looked_at(network, picture).next
    straight = network.infer(picture, region)
    mirrored = network.infer(picture, region, mirrored=True)
    joints = [NAMES.index(joint) for joint in JOINTS]
    apart = np.hypot(*(mirrored.uv - straight.uv)[joints].T)
    assert np.median(apart) < 0.01 * region.side
    exchanged = np.hypot(*(mirrored.exchanged().uv - straight.uv)[joints].T)
    assert np.median(exchanged) > 4 * np.median(apart)
    assert mirrored.p_hips[joints] == pytest.approx(straight.p_hips[joints], abs=0.25)
    assert mirrored.next.distance(straight.next) < 0.02


@dataclass
class _Dot:
    """A runtime whose network sees every point where the square is brightest, and a disc there."""

    channels_first: bool = False
    name: str = "dot"

    def run(self, image: np.ndarray) -> list[np.ndarray]:
        y, x = np.unravel_index(image[0].argmax(), (SIDE, SIDE))
        points = np.tile([x, y, 0.0, 5.0, 5.0], (39, 1)).astype(np.float32)
        metres = np.tile([x - SIDE / 2, y - SIDE / 2, 0.0], (39, 1)).astype(np.float32)
        heat = np.full((1, 64, 64, 39), -50, np.float32)
        rows, columns = np.indices((SIDE, SIDE))
        disc = np.where(np.hypot(rows - y, columns - x) < DISC, 8, -8).astype(np.float32)
        shape = (1, 1, SIDE, SIDE) if self.channels_first else (1, SIDE, SIDE, 1)
        return [points, np.ones(1, np.float32), disc.reshape(shape), heat, metres]


@pytest.mark.parametrize("turn_rad", [0.0, 0.7, -2.5])
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_point_is_told_where_it_is_in_the_picture(turn_rad: float, mirrored: bool) -> None:
    picture = np.zeros((240, 320, 3), np.uint8)
    cv2.circle(picture, (150, 130), 2, (255, 255, 255), -1)
    dot = BlazePose(FULL, _Dot())
    seen = dot.infer(picture, Region(160, 120, 120, turn_rad), mirrored=mirrored)
    assert seen.uv == pytest.approx(np.tile([150, 130], (33, 1)), abs=1.5)
    way = np.array([150 - 160, 130 - 120]) / np.hypot(10, 10)
    assert seen.p_hips[0, :2] / np.linalg.norm(seen.p_hips[0, :2]) == pytest.approx(way, abs=0.15)


@pytest.mark.parametrize("turn_rad", [0.0, 0.7, -2.5])
@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("channels_first", [False, True])
def test_a_mask_is_told_where_it_is_in_the_picture(
    turn_rad: float, mirrored: bool, channels_first: bool
) -> None:
    picture = np.zeros((240, 320, 3), np.uint8)
    cv2.circle(picture, (150, 130), 2, (255, 255, 255), -1)
    dot = BlazePose(FULL, _Dot(channels_first))
    seen = dot.infer(picture, Region(160, 120, 120, turn_rad), mirrored=mirrored)
    shown = seen.mask.in_picture(320, 240)
    rows, columns = np.indices(shown.shape)
    away = np.hypot(rows - 130, columns - 150) - DISC * 120 / SIDE
    assert (shown[away < -2] > 0.9).all()
    assert (shown[away > 2] < 0.1).all()


def test_a_mask_is_of_nobody_outside_the_square() -> None:
    region = Region(160, 120, 100, 0.4)
    shown = PersonMask.of(region, np.ones((SIDE, SIDE))).in_picture(320, 240)
    rows, columns = np.indices(shown.shape)
    c, s = np.cos(0.4), np.sin(0.4)
    x, y = columns - 160, rows - 120
    away = np.maximum(np.abs(c * x + s * y), np.abs(c * y - s * x)) - 50
    assert (shown.shape, shown.dtype) == ((240, 320), np.float32)
    assert (shown[away < -1] == 1).all()
    assert (shown[away > 1] == 0).all()


@pytest.mark.parametrize(
    "packed", [b"", b"none", zlib.compress(b"\0" * 9), zlib.compress(b"\xff" * SIDE**2)]
)
def test_what_is_packed_is_a_mask_or_is_refused(packed: bytes) -> None:
    with pytest.raises(ValueError, match=r"\w"):
        PersonMask(Region(160, 120, 100), packed).levels()


def test_a_mask_keeps_its_levels_and_a_few_kilobytes() -> None:
    share = np.linspace(0, 1, SIDE**2).reshape(SIDE, SIDE)
    mask = PersonMask.of(Region(160, 120, 100), share)
    assert np.abs(mask.levels() / FULL_LEVEL - share).max() <= 0.5 / FULL_LEVEL + 1e-9
    with cases.balance() as video:
        real = BlazePose.open(fast=False).infer(video.frame(0), Region.of_box(cases.BOX, 610, 735))
    assert len(real.mask.packed) < 4000


def test_marked_joints_of_a_real_man_lie_in_his_mask(network: BlazePose) -> None:
    inside = []
    with cases.balance() as video:
        for frame, marked in cases.marks().items():
            picture = video.frame(frame)
            height, width = picture.shape[:2]
            region = Region.of_box(cases.around(marked), width, height)
            seen = network.infer(picture, network.infer(picture, region).next)
            shown = seen.mask.in_picture(width, height)
            inside += [shown[round(v), round(u)] > 0.5 for u, v in (marked[j] for j in JOINTS)]
            assert 0.05 < (shown > 0.5).mean() < 0.3
    assert all(inside)


@pytest.mark.parametrize("grey", [0, 128, 255])
def test_nobody_is_in_a_flat_picture(network: BlazePose, grey: int) -> None:
    picture = np.full((240, 320, 3), grey, dtype=np.uint8)
    assert network.infer(picture, Region(160, 120, 200)).presence < 0.1


@pytest.mark.skipif(not fast_is_here(TFLITE), reason="LiteRT is not installed")
def test_litert_agrees_to_a_hundredth_of_a_pixel(network: BlazePose) -> None:
    picture = first_picture()
    region = Region.of_box(cases.BOX, picture.shape[1], picture.shape[0])
    one, other = network.infer(picture, region), BlazePose.open(fast=True).infer(picture, region)
    assert other.uv == pytest.approx(one.uv, abs=0.01)
    assert other.p_hips == pytest.approx(one.p_hips, abs=1e-4)
    assert np.abs(other.mask.levels().astype(int) - one.mask.levels()).max() <= 1


@pytest.mark.skipif(not fast_is_here(TFLITE), reason="LiteRT is not installed")
def test_litert_says_nothing_of_its_own(capfd: pytest.CaptureFixture[str]) -> None:
    BlazePose.open(fast=True)
    assert capfd.readouterr() == ("", "")


def test_litert_that_is_not_installed_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runtimes, "fast_is_here", lambda suffix: False)
    with pytest.raises(KeypointError, match="pip install ai-edge-litert"):
        BlazePose.open(fast=True)


def damaged(monkeypatch: pytest.MonkeyPatch, folder: Path, content: bytes) -> Model:
    """A network to be added whose file holds this."""
    monkeypatch.setattr(model_files, "added_folder", lambda: folder)
    (folder / HEAVY.file).write_bytes(content)
    return HEAVY


def test_the_bundled_network_is_the_one_it_is_named_for() -> None:
    assert hashlib.sha256(verified(FULL)).hexdigest() == FULL.sha256
    assert (FULL.path.with_name("LICENSE")).is_file()
    assert FULL.sha256 in (FULL.path.with_name("NOTICE")).read_text()


@pytest.mark.parametrize("content", [b"", b"\x1c\0\0\0TFL3", b"GIF89a" * 100])
def test_a_foreign_file_is_refused(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, content: bytes
) -> None:
    model = damaged(monkeypatch, tmp_path, content)
    with pytest.raises(KeypointError, match="damaged or is not the heavy network"):
        BlazePose.open(model)


def test_a_truncated_file_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    model = damaged(monkeypatch, tmp_path, FULL.path.read_bytes()[:-1])
    with pytest.raises(KeypointError, match="damaged"):
        BlazePose.open(replace(model, sha256=FULL.sha256))


def test_a_network_that_is_not_there_says_how_to_get_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(model_files, "added_folder", lambda: tmp_path)
    with pytest.raises(KeypointError, match="keypose models add heavy"):
        BlazePose.open(HEAVY)
