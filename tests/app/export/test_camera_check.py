"""A camera from a file beside the background of its film: what is said of it."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from keypose.app.export.import_camera import brought, reading_of
from keypose.app.orders.imports import ImportCamera
from keypose.app.words.imports import note_words
from keypose.tracker.formats.reading_camera import CameraFile, load_camera
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.session import Session, VideoReference
from keypose.tracker.video import Video
from tests.tracker import session_cases as cases

COUNT = 48
WIDTH = 256
HEIGHT = 144
FOCAL = 300.0
FLIP = np.diag([1.0, -1.0, -1.0])
FIRST = 20
"""Number of the film's first picture."""


def angles_deg() -> Any:
    """(N, 3) about x, y, z, in the order ZXY: a pan that speeds up, tilted and rolled."""
    t = np.arange(COUNT) / COUNT
    return np.stack([-20 + 3 * np.sin(7 * t), -14 * t**2 - np.sin(11 * t), 4 + 2 * t], axis=1)


def Rs_world_camera() -> Any:
    x, y, z = angles_deg().T
    return Rotation.from_euler("YXZ", np.stack([y, x, z], axis=1), True).as_matrix()


@lru_cache(maxsize=1)
def wall() -> Any:
    rng, made = np.random.default_rng(5), np.zeros((500, 700), np.float32)
    for scale in (2, 5, 13):
        noise = rng.normal(0, 1, (500 // scale + 2, 700 // scale + 2)).astype(np.float32)
        made += cv2.resize(noise, (700, 500), interpolation=cv2.INTER_CUBIC) * scale**0.5
    return cv2.normalize(made, None, 10, 245, cv2.NORM_MINMAX)  # type: ignore[call-overload]


def write_film(folder: Path, kind: str = "pans") -> Session:
    """A film of a far wall, by a camera that pans or stands still; or of nothing to be seen."""
    (folder / "film").mkdir()
    Rs = Rs_world_camera() @ FLIP
    K = np.array([[FOCAL, 0, (WIDTH - 1) / 2], [0, FOCAL, (HEIGHT - 1) / 2], [0, 0, 1.0]])
    beyond = np.array([[FOCAL, 0, 330], [0, FOCAL, 250], [0, 0, 1.0]])
    rng = np.random.default_rng(1)
    for n in range(COUNT):
        R = Rs[0 if kind == "stands" else n].T @ Rs[COUNT // 2]
        H = K @ R @ np.linalg.inv(beyond)
        grey = cv2.warpPerspective(wall(), H, (WIDTH, HEIGHT), flags=cv2.INTER_CUBIC)
        if kind == "empty":
            grey = np.full((HEIGHT, WIDTH), 128.0, np.float32)
        if kind == "boils":
            grey = rng.normal(128, 60, (HEIGHT, WIDTH)).astype(np.float32)
        picture = np.clip(grey, 0, 255).astype(np.uint8)
        assert cv2.imwrite(str(folder / "film" / f"shot.{FIRST + n:04}.png"), picture)
    camera = Camera(
        width=WIDTH, height=HEIGHT, fx=FOCAL, fy=FOCAL, cx=(WIDTH - 1) / 2, cy=(HEIGHT - 1) / 2
    )
    video = VideoReference(
        path="film", fingerprint="", frame_count=COUNT, width=WIDTH, height=HEIGHT
    )
    return Session.begin(video=video, camera=camera, body=cases.body(), keyframes=())


@pytest.fixture(scope="module")
def films(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, Session]]:
    made = {}
    for kind in ("pans", "stands", "empty", "boils"):
        folder = tmp_path_factory.mktemp(kind)
        made[kind] = folder / "film", write_film(folder, kind)
    return made


def chan(
    order: str = "zxy", last: float | None = None, frames: range = range(COUNT), shift: int = 0
) -> str:
    R = Rotation.from_matrix(Rs_world_camera()[list(frames)])
    angles = dict(zip(order, R.as_euler(order, True).T, strict=True))
    last = 2 * np.degrees(np.arctan(HEIGHT / 2 / FOCAL)) if last is None else last
    return "\n".join(
        f"{frame + shift} 0 1.5 0 {angles['x'][k]} {angles['y'][k]} {angles['z'][k]} {last}"
        for k, frame in enumerate(frames)
    )


def compared(
    film: tuple[Path, Session], folder: Path, content: str, **said: Any
) -> tuple[CameraFile, str]:
    (folder / "shot.chan").write_text(content)
    (path, session), order = film, ImportCamera(**said)
    found = load_camera(folder / "shot.chan", (WIDTH, HEIGHT), reading_of(order))
    with Video.open(path) as video:
        found = brought(session, found, "shot.chan", order, video)
    return found, " ".join(note_words(found.notes))


PART = range(8, 40)
ACROSS = float(2 * np.degrees(np.arctan(WIDTH / 2 / FOCAL)))


@pytest.mark.parametrize(
    ("content", "said", "words"),
    [
        (chan(), {}, ""),
        (chan(frames=PART), {}, ""),
        (chan("xyz"), {}, "With the rotation order XYZ (--rotation-order xyz) they agree"),
        (chan("xyz"), {"rotation_order": "xyz"}, ""),
        (chan("yxz"), {}, "--rotation-order yxz"),
        (chan(last=FOCAL / WIDTH * 36), {}, "--lens-column mm"),
        (chan(last=FOCAL / WIDTH * 36), {"lens_column": "mm"}, ""),
        (chan(last=ACROSS), {}, "--lens-column horizontal"),
        (chan(last=60), {}, "--lens-column session"),
        (chan(frames=PART, shift=6), {}, "With the start frame -6 (--offset-frames -6)"),
        (chan(frames=PART, shift=-7), {}, "With the start frame 7 (--offset-frames 7)"),
        (chan(frames=PART, shift=1000), {"offset_frames": -1000}, ""),
        (chan(frames=PART, shift=FIRST), {}, "by the numbers of the film's pictures"),
    ],
)
def test_a_camera_that_the_background_contradicts_is_told_with_what_would_suit_it(
    films: dict[str, tuple[Path, Session]],
    tmp_path: Path,
    content: str,
    said: dict[str, Any],
    words: str,
) -> None:
    found, told = compared(films["pans"], tmp_path, content, **said)
    assert words in told
    is_contradicted = "background are" in told
    assert is_contradicted is ("With " in told)
    assert found.background_px is not None
    assert (found.background_px > 0.3) is is_contradicted
    assert found.way is not None  # as the file has it, whatever would be better
    if "(" in told and "With" in told:
        as_read, _ = compared(films["pans"], tmp_path, content, **said)
        assert as_read.way is not None
        np.testing.assert_array_equal(as_read.way.Ts_world_camera, found.way.Ts_world_camera)


def test_a_camera_of_another_shot_is_told(
    films: dict[str, tuple[Path, Session]], tmp_path: Path
) -> None:
    other = "\n".join(f"{n} 0 0 0 {3 * np.sin(n / 3)} {n} 0 27" for n in range(COUNT))
    _, told = compared(films["pans"], tmp_path, other)
    assert "the file may have another rotation order, other frame numbers or another lens" in told
    _, told = compared(films["stands"], tmp_path, chan())
    assert told.startswith("The background of the film stands still, and with this camera")


@pytest.mark.parametrize("kind", ["empty", "boils"])
def test_where_the_background_tells_nothing_nothing_is_said_of_it(
    films: dict[str, tuple[Path, Session]], tmp_path: Path, kind: str
) -> None:
    for content in (chan(), chan("xyz")):
        found, told = compared(films[kind], tmp_path, content)
        assert found.background_px is None
        assert told == ""


def test_a_unit_that_makes_a_camera_race_is_told(
    films: dict[str, tuple[Path, Session]], tmp_path: Path
) -> None:
    lines = [line.split(" ") for line in chan().splitlines()]
    far = "\n".join(" ".join([n, str(30 * float(n)), *rest]) for n, _, *rest in lines)
    assert "choose the unit (--unit cm)" in compared(films["stands"], tmp_path, far)[1]
    assert "--unit" not in compared(films["stands"], tmp_path, far, unit="cm")[1]


def test_without_the_film_a_camera_is_taken_and_that_is_said(tmp_path: Path) -> None:
    session = write_film(tmp_path)
    (tmp_path / "shot.chan").write_text(chan())
    found = load_camera(tmp_path / "shot.chan", (WIDTH, HEIGHT))
    found = brought(session, found, "shot.chan", ImportCamera(), None)
    assert note_words(found.notes) == [
        "The film cannot be opened, so the camera was not compared with its background."
    ]
