"""Films of a session: what is in them, when it is shown, and that the body stays in the picture."""

from __future__ import annotations

import json
import signal
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.app.orders.drawing import Viewpoint
from keypose.app.render import films
from keypose.app.render.films import Film, film_pictures, film_size
from keypose.app.render.palette import Picture
from keypose.app.render.pictures import FourViewLayout
from keypose.app.render.poses import KnownPoses
from keypose.app.render.studio import Studio, ViewStyle, snapshot
from keypose.tracker.body.pose import Pose
from keypose.tracker.storage.files import load_session, open_video_of, save_session
from keypose.tracker.storage.tracks import save_result
from keypose.tracker.video import Video
from keypose.tracker.video.encode import FilmWriter
from tests.app.cli_cases import everything_in, refused
from tests.tracker import session_cases as cases

LARGE = (160, 120)


def film(session: Path, out: Path, *more: str) -> int:
    return main(["film", str(session), "--out", str(out), *more])


def wandering(step_m: float = 0.3, count: int = cases.FRAMES) -> KnownPoses:
    """A body that walks to the right and away, its first frames known."""
    start, way = cases.pose(0.0), np.array([step_m, 0.0, step_m])
    places = [start.p_camera_root + frame * way for frame in range(count)]
    poses = {i: Pose(start.Rs_parent_part, place) for i, place in enumerate(places)}
    return KnownPoses(cases.SKELETON, poses, None)


def drawn(poses: KnownPoses, wanted: Film) -> list[Picture]:
    return list(film_pictures(cases.session(), None, poses, wanted, 25.0))


def body_box(picture: Picture) -> Any:
    """Left, top, right, bottom of the strong colours, which only the body has."""
    rows, columns = np.nonzero(np.ptp(picture.astype(int), axis=2) > 60)
    return np.array([columns.min(), rows.min(), columns.max(), rows.max()])


def test_a_film_is_the_shots_of_all_frames_one_after_the_other(
    tracked_path: Path, tmp_path: Path
) -> None:
    session = load_session(tracked_path)
    poses = KnownPoses.of(session, tracked_path)
    with open_video_of(session, tracked_path) as video:
        pictures = list(film_pictures(session, video, poses, Film("main", 2, 6), 25.0))
        for number, picture in zip(range(2, 7), pictures, strict=True):
            pose = poses.pose(number)
            assert pose is not None
            expected = snapshot(session, video, number, pose, ViewStyle())
            np.testing.assert_array_equal(picture, expected)


def test_the_file_holds_what_was_drawn_at_the_videos_times(
    tracked_path: Path, tmp_path: Path
) -> None:
    out = tmp_path / "film.mp4"
    assert film(tracked_path, out, "--frames", "1-7", "--size", "128x96") == 0
    session = load_session(tracked_path)
    poses = KnownPoses.of(session, tracked_path)
    with open_video_of(session, tracked_path) as video, Video.open(out) as found:
        times_s = video.info.times_s
        assert found.info.frame_count == 7
        assert (found.info.width, found.info.height) == (128, 96)
        np.testing.assert_allclose(found.info.times_s, times_s[1:8] - times_s[1], atol=1e-9)
        wanted = Film("main", 1, 7, size=(128, 96))
        for i, picture in enumerate(film_pictures(session, video, poses, wanted, 25.0)):
            smooth, seen = (cv2.GaussianBlur(p, (0, 0), 1.5) for p in (picture, found.frame(i)))
            error = (smooth.astype(float) - seen) ** 2  # the video is noise, which no film keeps
            assert 10 * np.log10(255**2 / error.mean()) > 28


def test_the_uneven_times_of_a_video_are_kept(tmp_path: Path) -> None:
    pts = [0, 3, 4, 11, 40, 41, 43, 90, 91]
    clip = tmp_path / "clip.mp4"
    with FilmWriter(clip, (cases.WIDTH, cases.HEIGHT), Fraction(1, 600), Fraction(25)) as writer:
        for number, at in enumerate(pts):
            writer.add(np.full((cases.HEIGHT, cases.WIDTH, 3), 25 * number, np.uint8), at)
    session = cases.session(clip)
    reference = session.view.video.model_copy(update={"path": "clip.mp4"})
    save_session(session.changed({"video": reference}), tmp_path / "session.json")
    for view in ("main", "side"):
        out = tmp_path / f"{view}.mp4"
        assert film(tmp_path / "session.json", out, "--frames", "2-8", "--view", view) == 0
        with Video.open(out) as found:
            assert found.info.variable_rate
            expected = [(at - pts[2]) / 600 for at in pts[2:]]
            np.testing.assert_allclose(found.info.times_s, expected, atol=1e-9)


def test_a_rate_asked_for_sets_the_times(tracked_path: Path, tmp_path: Path) -> None:
    out = tmp_path / "film.mp4"
    assert film(tracked_path, out, "--fps", "12.5", "--view", "side") == 0
    with Video.open(out) as found:
        np.testing.assert_allclose(found.info.times_s, np.arange(cases.FRAMES) / 12.5, atol=1e-9)


@pytest.mark.parametrize("view", ["main", "top", "all", "orbit", "camera:30,10", "camera:-60,5,9"])
def test_every_view_is_filmed_and_reported_in_json(
    tracked_path: Path, tmp_path: Path, view: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "film.mp4"
    assert film(tracked_path, out, "--view", view, "--json") == 0
    reported = json.loads(capsys.readouterr().out)
    assert reported["written"] == [str(out)]
    with Video.open(out) as found:
        assert found.info.frame_count == cases.FRAMES
        assert (found.info.width, found.info.height) == (reported["width"], reported["height"])
        assert np.ptp(found.frame(4).astype(int)) > 60


def test_odd_sizes_become_even(tracked_path: Path) -> None:
    poses = wandering()
    odd = Film("main", 0, 8, size=(101, 75))
    assert film_size(cases.session(), poses, odd) == (102, 76)
    assert drawn(poses, odd)[0].shape == (76, 102, 3)


@pytest.mark.parametrize("size", [(160, 120), (120, 200)])
def test_the_body_is_in_view_all_the_way_round(size: tuple[int, int]) -> None:
    pictures = drawn(wandering(), Film("orbit", 0, 8, size=size))
    assert len(pictures) == cases.FRAMES
    for picture in pictures:
        left, top, right, bottom = body_box(picture)
        assert left > 0
        assert top > 0
        assert right < size[0] - 1
        assert bottom < size[1] - 1


def test_an_orbit_begins_as_the_camera_looks_and_passes_behind_the_body() -> None:
    still = KnownPoses(cases.SKELETON, dict.fromkeys(range(8), cases.pose(0.0)), None)
    session = cases.session()
    pictures = list(film_pictures(session, None, still, Film("orbit", 0, 7, size=LARGE), 25.0))

    def side(picture: Picture) -> float:
        """Where the left, blue arm is beside the right, orange one, in pixels."""
        rgb = picture.astype(int)
        blue, orange = rgb[..., 2] - rgb[..., 0] > 60, rgb[..., 0] - rgb[..., 2] > 60
        return float(np.nonzero(blue)[1].mean() - np.nonzero(orange)[1].mean())

    assert side(pictures[0]) > 10  # the body faces the camera: its left is on the right
    assert side(pictures[4]) < -10


def test_a_standing_camera_stands_still() -> None:
    """Away from the body and its shadow, no line of the grid moves."""
    *pictures, empty = drawn(wandering(0.1, 8), Film(Viewpoint(20.0, 15.0), 0, 8, size=LARGE))
    same = np.all([(picture == empty).all(axis=2) for picture in pictures], axis=0)
    assert same.mean() > 0.3
    assert (same & (empty < 225).any(axis=2)).sum() > 200  # lines among them
    assert body_box(pictures[-1])[0] != body_box(pictures[0])[0]


@pytest.mark.parametrize("view", ["top", "side", "front", "all"])
def test_a_view_keeps_its_scale_and_place_and_shows_the_whole_way(view: str) -> None:
    """The body is what differs from the frame that has none."""
    wanted = Film(view, 0, 8, size=(320, 160))  # type: ignore[arg-type]
    *pictures, empty = drawn(wandering(count=8), wanted)
    for place in _places(view):
        sizes = []
        for picture in pictures:
            differs = (picture[place] != empty[place]).any(axis=2)
            assert differs.any()
            assert not differs[[0, -1]].any()
            assert not differs[:, [0, -1]].any()
            rows, columns = np.nonzero(differs)
            sizes.append((np.ptp(rows), np.ptp(columns)))
        assert np.ptp(sizes, axis=0).max() <= 2


def _places(view: str) -> list[tuple[slice, slice]]:
    """The pictures along parallel rays within the film's."""
    if view != "all":
        return [(slice(None), slice(None))]
    studio = Studio.of(cases.session(), cases.SKELETON)
    four = FourViewLayout.of(studio.camera, studio.height_of_four((320, 160)))
    top, left = (160 - four.main[1]) // 2, (320 - four.width) // 2 + four.main[0] + four.gap
    places = []
    for width, height in four.small:
        places.append((slice(top, top + height), slice(left, left + width)))
        top += height + four.gap
    return places


def test_frames_without_a_pose_are_shown_without_the_body_and_counted(
    session_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    session = load_session(session_path)
    parts = cases.result(cases.segment(6, 8), cases.segment(0, 3))
    save_session(save_result(session, session_path, parts), session_path)
    assert film(session_path, tmp_path / "film.mp4") == 0
    note = "1 of the film's 9 frames have no pose and show no body."
    assert note in capsys.readouterr().err
    session = load_session(session_path)
    poses = KnownPoses.of(session, session_path)
    assert poses.pose(5) is None
    with open_video_of(session, session_path) as video:
        pictures = list(film_pictures(session, video, poses, Film("main", 4, 6), 25.0))
        np.testing.assert_array_equal(pictures[1], video.frame(5))
        assert (pictures[0] != video.frame(4)).any()


def test_without_the_video_a_new_camera_films_at_the_keyframes_pace(
    tracked_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tracked_path.parent / "frames").rename(tmp_path / "elsewhere")
    out = tmp_path / "film.mp4"
    assert film(tracked_path, out, "--view", "orbit") == 0
    assert "the video is missing" in capsys.readouterr().err
    with Video.open(out) as found:
        np.testing.assert_allclose(found.info.times_s, np.arange(9) / 25, atol=1e-9)


@pytest.mark.parametrize("count", [0, 1])
def test_with_neither_video_nor_two_keyframes_a_film_has_25_frames_a_second(
    tracked_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], count: int
) -> None:
    (tracked_path.parent / "frames").rename(tmp_path / "elsewhere")
    cases.altered(tracked_path, lambda data: data.update(keyframes=data["keyframes"][:count]))
    out = tmp_path / "film.mp4"
    assert film(tracked_path, out, "--view", "orbit") == 0
    assert "25 frames a second" in capsys.readouterr().err
    with Video.open(out) as found:
        np.testing.assert_allclose(found.info.times_s, np.arange(9) / 25, atol=1e-9)


def test_a_path_of_a_video_that_no_file_can_have_is_a_missing_video(
    tracked_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cases.altered(tracked_path, lambda data: data["video"].update(path="x" * 300 + ".mp4"))
    assert film(tracked_path, tmp_path / "film.mp4", "--view", "orbit") == 0
    assert "the video is missing" in capsys.readouterr().err


def test_ctrl_c_leaves_no_file(
    tracked_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    ahead = films._ahead

    def interrupted(draw: Any, images: Any) -> Iterator[Picture]:
        for i, picture in enumerate(ahead(draw, images)):
            if i == 4:
                signal.raise_signal(signal.SIGINT)
            yield picture

    monkeypatch.setattr(films, "_ahead", interrupted)
    before = everything_in(tmp_path)
    assert film(tracked_path, tmp_path / "film.mp4") == 130
    assert everything_in(tmp_path) == before


def test_only_a_few_frames_are_held_at_a_time() -> None:
    taken = 0

    def images() -> Iterator[tuple[int, None]]:
        nonlocal taken
        for number in range(100):
            taken += 1
            yield number, None

    blank = np.zeros((2, 2, 3), np.uint8)
    for used, _ in enumerate(films._ahead(lambda number, image: blank, images())):
        assert taken <= used + films.THREADS + 2


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (["--out", "film.avi"], "must end in .mp4"),
        (["--out", "film.mp4", "--frames", "9-2"], "are no frames such as 10-60"),
        (["--out", "film.mp4", "--frames", "2-9"], "There is no frame 9"),
        (["--out", "film.mp4", "--fps", "0"], "is not a rate"),
        (["--out", "film.mp4", "--fps", "1e9999999"], "is not a rate"),
        (["--out", "film.mp4", "--fps", "1/0"], "is not a rate"),
        (["--out", "film.mp4", "--view", "camera:10"], "is not a view"),
        (["--out", "film.mp4", "--view", "orbit:10"], None),
        (["--out", "absent/film.mp4"], "absent/film.mp4' cannot be written"),
    ],
)
def test_what_cannot_be_filmed_is_refused_in_one_sentence(
    tracked_path: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    more: list[str],
    sentence: str | None,
) -> None:
    monkeypatch.chdir(tmp_path)
    if sentence is None:  # one side of an orbit is a viewpoint, too
        assert main(["film", str(tracked_path), *more]) == 0
        return
    assert sentence in refused(capsys, tmp_path, ["film", tracked_path, *more])


def test_a_film_that_is_there_is_not_overwritten_unless_asked(
    tracked_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "film.mp4"
    out.write_text("mine")
    assert "exists already" in refused(capsys, tmp_path, ["film", tracked_path, "--out", out])
    assert film(tracked_path, out, "--view", "top", "--overwrite") == 0
    assert out.stat().st_size > 100


def test_a_session_without_keyframes_has_nothing_to_film(
    session_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cases.altered(session_path, lambda data: data.update(keyframes=[]))
    command: list[str | Path] = ["film", session_path, "--out", tmp_path / "film.mp4"]
    assert "has no pose to film" in refused(capsys, tmp_path, command)


def test_a_stretch_without_any_pose_is_refused(
    session_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command: list[str | Path] = ["film", session_path, "--out", tmp_path / "film.mp4"]
    sentence = refused(capsys, tmp_path, [*command, "--frames", "1-3"])
    assert "Frames 1 to 3 have no pose" in sentence
