"""`keypose matte`: the person with alpha, frame by frame, whole or not at all."""

from __future__ import annotations

import json
import shutil
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import av
import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from keypose import sample_videos
from keypose.app.cli import matte as command
from keypose.app.cli.main import main
from keypose.app.export.picture_names import picture_names
from keypose.app.orders.drawing import MatteOrder
from keypose.tracker.body.body import preset
from keypose.tracker.keypoints.blazepose import NAMES, Seen
from keypose.tracker.keypoints.people import GREY
from keypose.tracker.keypoints.region import Region
from keypose.tracker.session.annotations import Drafted, DraftPlace
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.tracking.cues import sources
from keypose.tracker.video import Video
from tests.app.cli_cases import everything_in, refused
from tests.tracker.keypoints.keypoint_cases import BALANCE, disc
from tests.tracker.video_cases import numbered_picture, write_image

HIDDEN = 2
"""The frame that shows nobody."""
PLACE = Region(260.0, 420.0, 480.0)


@dataclass
class Disc:
    """A network that sees the same body everywhere, as a disc, but in one picture."""

    empty: NDArray[np.uint8]
    fingerprint: str = "disc"

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        uv = np.full((len(NAMES), 2), (PLACE.x, PLACE.y))
        there = float(not np.array_equal(picture, self.empty))
        p_hips = np.zeros((len(NAMES), 3))
        return Seen(uv, np.ones(len(NAMES)), p_hips, there, PLACE, disc(PLACE))


@pytest.fixture
def session(
    tmp_path: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch
) -> Path:
    shutil.copytree(BALANCE, tmp_path / "balance")
    network = Disc(film(HIDDEN, HIDDEN)[0])
    monkeypatch.setattr(sources, "_network", lambda model: network)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
    return tmp_path / "balance" / "session.json"


def film(first: int, last: int) -> list[NDArray[np.uint8]]:
    with Video.open(BALANCE / "balance.mp4") as video:
        return [video.frame(n) for n in range(first, last + 1)]


def run(*arguments: str | Path) -> int:
    return main(["matte", *map(str, arguments)])


def expected(frame: int) -> NDArray[np.uint8]:
    height, width = film(0, 0)[0].shape[:2]
    share = disc(PLACE).in_picture(width, height) * (frame != HIDDEN)
    return np.asarray(np.round(255 * share), np.uint8)


def test_pictures_are_the_film_with_straight_alpha(
    session: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(session, "--frames", "1-3", "--out", tmp_path / "out") == 0
    out, err = capsys.readouterr()
    assert out == f"Written: 3 pictures in {tmp_path / 'out'}\n"
    assert "No person was found in 1 of the 3 frames: their alpha is empty." in err
    names = sorted(path.name for path in (tmp_path / "out").iterdir())
    assert names == [f"frame000{n}.png" for n in (1, 2, 3)]
    for name, number, filmed in zip(names, (1, 2, 3), film(1, 3), strict=True):
        picture = cv2.imread(str(tmp_path / "out" / name), cv2.IMREAD_UNCHANGED)
        assert picture is not None
        assert np.array_equal(picture[..., 2::-1], filmed)
        assert np.array_equal(picture[..., 3], expected(number))


def test_the_alpha_alone_is_grey(
    session: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(session, "--frames", "1-1", "--alpha-only", "--out", tmp_path) == 0
    assert capsys.readouterr().out == f"Written: 1 picture in {tmp_path}\n"
    picture = cv2.imread(str(tmp_path / "frame0001.png"), cv2.IMREAD_UNCHANGED)
    assert np.array_equal(picture, expected(1))


@dataclass
class Pair:
    """A network that sees whichever of two bodies is nearer to a region, and keeps of what it was
    shown the levels in the middle of both."""

    places: tuple[Region, Region]
    shown: list[tuple[int, bool, bool]] = field(default_factory=list)
    fingerprint: str = "pair"

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        index = int(np.argmin([abs(region.x - place.x) for place in self.places]))
        place = self.places[index]
        grey = [(picture[int(each.y), int(each.x)] == GREY).all() for each in self.places]
        self.shown.append((index, bool(grey[0]), bool(grey[1])))
        spread = np.linspace(-0.3, 0.3, len(NAMES))[:, None] * place.side
        uv = np.array([place.x, place.y]) + spread
        ones, p_hips = np.ones(len(NAMES)), np.zeros((len(NAMES), 3))
        return Seen(uv, ones, p_hips, 1.0, place, disc(place))


@pytest.mark.parametrize("two", [False, True], ids=["alone", "beside another body"])
def test_the_other_bodies_of_a_session_are_painted_out_before_the_person_is_looked_for(
    session: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, two: bool
) -> None:
    network = Pair((PLACE, Region(PLACE.x + 170.0, PLACE.y, 240.0)))
    monkeypatch.setattr(sources, "_network", lambda model: network)
    doc = load_session(session)
    keyframe = doc.subject.keyframes[0]
    x, y, z = keyframe.root_m
    beside = keyframe.model_copy(update={"root_m": (x + 170.0 * z / doc.view.camera.fx, y, z)})
    first = doc.subject.model_copy(update={"keyframes": (keyframe,), "results": None})
    second = first.model_copy(update={"id": "second", "keyframes": (beside,)})
    bodies = (first, second) if two else (first,)
    save_session(doc.model_copy(update={"bodies": bodies}), session)
    assert run(session, "--frames", "1-3", "--alpha-only", "--out", tmp_path / "out") == 0
    looks = [look for look in network.shown if look[0] == 0]
    assert len(looks) >= 3
    assert not any(own_is_grey for _, own_is_grey, _ in looks)
    assert any(is_grey for _, _, is_grey in looks) == two


def test_the_person_who_is_named_is_cut_out_and_the_first_where_a_thing_stands_before(
    session: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    doc = load_session(session)
    ball = TrackedBody(id="ball", body=preset("box"))
    unposed = TrackedBody(id="unposed", body=doc.subject.body)
    save_session(doc.model_copy(update={"bodies": (ball, doc.subject, unposed)}), session)
    assert run(session, "--frames", "1-1", "--out", tmp_path / "out") == 0
    assert f"This is {doc.subject.id}; choose with --body." in capsys.readouterr().err
    assert run(session, "--body", "ball", "--out", tmp_path / "ball") == 2
    assert "is about no person" in capsys.readouterr().err
    assert run(session, "--body", "unposed", "--out", tmp_path / "unposed") == 2
    assert "does not say where the person is" in capsys.readouterr().err


def decoded(path: Path) -> list[av.VideoFrame]:
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        if path.suffix == ".mov":
            return list(container.decode(stream))
        decoder = av.CodecContext.create("libvpx-vp9", "r")  # the usual one leaves alpha out
        packets = [packet for packet in container.demux(stream) if packet.size]
        return [frame for packet in (*packets, None) for frame in decoder.decode(packet)]  # type: ignore[misc]


@pytest.mark.parametrize("kind", ["webm", "mov"])
@pytest.mark.parametrize("alone", [False, True])
def test_a_film_has_the_pictures_and_the_alpha_of_its_frames(
    session: Path, tmp_path: Path, kind: str, alone: bool
) -> None:
    out = tmp_path / f"a.{kind}"
    more = ("--alpha-only",) if alone else ()
    assert run(session, "--frames", "1-3", "--kind", kind, *more, "--out", out) == 0
    frames = decoded(out)
    assert [frame.format.name.startswith("yuva") for frame in frames] == [not alone] * 3
    for number, filmed, frame in zip((1, 2, 3), film(1, 3), frames, strict=True):
        picture = frame.to_ndarray(format="rgba").astype(int)
        alpha = picture[..., 0 if alone else 3]
        assert np.abs(alpha - expected(number)).mean() < 2
        if not alone:
            assert np.abs(picture[..., :3] - filmed).mean() < 8
    with Video.open(BALANCE / "balance.mp4") as video:
        times = video.info.times_s[1:4] - video.info.times_s[1]
    assert [frame.time for frame in frames] == pytest.approx(times, abs=1e-3)


def test_json_has_the_files_and_the_empty_frames(
    session: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run(session, "--frames", "2-3", "--json", "--out", tmp_path / "out") == 0
    files = [str(tmp_path / "out" / f"frame000{n}.png") for n in (2, 3)]
    assert json.loads(capsys.readouterr().out) == {
        **{"written": files, "frames": [2, 3], "empty": [2], "maybe_another": []}
    }


ANOTHER: dict[str, tuple[list[int], int, str, str, list[int]]] = {
    "from there on": ([0], 2, "1-3", "From frame 2 on it may be another person", [2, 3]),
    "beyond it alone": ([0], 2, "3-4", "From frame 2 on it may be another person", [3, 4]),
    "before the person": ([4], 2, "1-3", "Before frame 2 it may be another person", [1]),
    "not as far as asked": ([0], 4, "1-3", "", []),
    "not so far back": ([4], 1, "1-3", "", []),
    "a keyframe there": ([0, 2], 2, "1-3", "", []),
    "a keyframe after it": ([0, 4], 2, "1-3", "", []),
}
"""Keyframes, the change, frames asked for, what is said, and the frames it is said of."""


@pytest.mark.parametrize("said_by", ["the draft", "a look back"])
@pytest.mark.parametrize("case", ANOTHER)
def test_where_it_may_be_another_person_is_said_as_the_draft_says_it(
    session: Path,
    tmp_path: Path,
    case: str,
    said_by: str,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    posed, change, frames, words, of = ANOTHER[case]
    doc = load_session(session)
    keyframes = tuple(
        doc.subject.keyframes[0].model_copy(update={"frame": n, "time_s": n / 30}) for n in posed
    )
    update: dict[str, object] = {"keyframes": keyframes}
    if said_by == "the draft":
        place = DraftPlace(frame=change, reason="person")
        update |= {"drafted": Drafted(first_frame=0, last_frame=9, places=(place,))}
    monkeypatch.setattr(sources, "people_changes", lambda *given, **named: [(change,)])
    save_session(doc.changed(update), session)
    assert run(session, "--frames", frames, "--json", "--out", tmp_path / "out") == 0
    out, err = capsys.readouterr()
    assert json.loads(out)["maybe_another"] == of
    assert words in err
    assert ("another person" in err) == bool(words)


NUMBERED: dict[str, tuple[list[str], list[str]]] = {
    "a shot": ([f"shot.{n}.png" for n in range(1001, 1005)], ["frame1002.png", "frame1003.png"]),
    "with a gap": (["a_7.png", "a_9.png", "a_12.png"], ["frame0009.png", "frame0012.png"]),
    "large": ([f"{n}.png" for n in range(86399, 86403)], ["frame86400.png", "frame86401.png"]),
    "doubled": (["a1.png", "b1.png", "c1.png"], ["frame0001.png", "frame0002.png"]),
    "none": (["a.png", "b.png", "c.png"], ["frame0001.png", "frame0002.png"]),
}


@pytest.mark.parametrize("case", NUMBERED)
def test_pictures_of_numbered_pictures_have_their_numbers(tmp_path: Path, case: str) -> None:
    files, names = NUMBERED[case]
    for name in files:
        write_image(tmp_path / name, numbered_picture(0))
    with Video.open(tmp_path) as video:
        assert picture_names(video.info, [1, 2]) == names


def without_keyframes(path: Path) -> None:
    save_session(load_session(path).changed({"keyframes": ()}), path)


def of_a_box(path: Path) -> None:
    shutil.copytree(Path(sample_videos.__file__).with_name("box"), path.parent, dirs_exist_ok=True)


WRONG: dict[str, tuple[Any, tuple[str, ...], str]] = {
    "nothing to start from": (without_keyframes, (), "does not say where the person is"),
    "a box": (of_a_box, (), "only a person in a film is cut out"),
    "frames beyond": (None, ("--frames", "3-9999"), "There is no frame 9999"),
    "another ending": (None, ("--kind", "webm"), "must end in .webm"),
    "nobody": (None, ("--frames", "2-2"), "No person was found in frames 2 to 2"),
}


@pytest.mark.parametrize("case", WRONG)
def test_what_cannot_be_cut_out_is_refused_in_a_sentence(
    session: Path, tmp_path: Path, case: str, capsys: pytest.CaptureFixture[str]
) -> None:
    change, options, words = WRONG[case]
    if change is not None:
        change(session)
    arguments = ["matte", session, *options, "--out", tmp_path / "out"]
    assert words in refused(capsys, tmp_path, arguments)


@pytest.mark.parametrize(("kind", "out"), [("png", "."), ("mov", "a.mov")])
def test_what_is_there_stays_unless_it_is_to_be_overwritten(
    session: Path, tmp_path: Path, kind: str, out: str, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["matte", session, *("--frames", "1-1", "--kind", kind, "--out"), tmp_path / out]
    there = tmp_path / ("frame0001.png" if kind == "png" else out)
    there.write_bytes(b"mine")
    assert "exists already" in refused(capsys, tmp_path, arguments)
    assert run(*arguments[1:], "--overwrite") == 0
    assert there.stat().st_size > 1000


@pytest.mark.parametrize(
    ("kind", "left", "files"), [("png", 2, 1), ("png", 9, 0), ("webm", 2, 0), ("mov", 9, 0)]
)
def test_an_interrupted_matte_leaves_whole_files_alone(
    session: Path, tmp_path: Path, kind: str, left: int, files: int, monkeypatch: Any
) -> None:
    """left: steps to go when that happens, of which the last three are pictures."""
    of = command.matte_of

    def interrupted(*given: Any) -> Any:
        def progress(done: int, expected: int) -> None:
            if expected - done <= left:
                raise KeyboardInterrupt

        return of(*given[:-1], progress)

    monkeypatch.setattr(command, "matte_of", interrupted)
    out = tmp_path / ("out" if kind == "png" else f"out.{kind}")
    before = set(everything_in(tmp_path))
    assert run(session, "--frames", "0-2", "--kind", kind, "--out", out) == 130
    made = set(everything_in(tmp_path)) - before
    assert len(made) == files
    assert all(cv2.imread(str(tmp_path / name)) is not None for name in made)


def test_drafts_say_where_the_person_is_where_there_is_no_keyframe(
    session: Path, tmp_path: Path
) -> None:
    doc = load_session(session)
    save_session(doc.changed({"keyframes": (), "drafts": doc.subject.keyframes[:1]}), session)
    assert run(session, "--frames", "1-1", "--out", tmp_path / "out") == 0


def test_an_order_of_nothing_is_of_all_frames_as_pictures() -> None:
    assert MatteOrder() == MatteOrder("png", None, False)
