"""What the product promises of videos: exact frames by number, or one plain sentence."""

from __future__ import annotations

import os
import shutil
import threading
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import av
import av.error
import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from keypose.tracker.errors import VideoError
from keypose.tracker.video import MissingFrame, Video
from keypose.tracker.video import decode as decode_module
from keypose.tracker.video.container import decode
from keypose.tracker.video.index import index_from_decoding, index_from_packets
from keypose.tracker.video.video import PictureCache
from tests.tracker.video_cases import (
    ask_for_turn,
    damage_packet,
    decoded_plainly,
    number_in,
    numbered_picture,
    write_clip,
    write_cut,
    write_image,
    write_numbered,
    write_pieces,
    write_sound,
    write_with_foreign_tags,
)

SHARED = Path(__file__).parents[4] / "shared/data"
LONG_GOP = {"bf": "3", "g": "250"}


def numbers(video: Video, order: list[int]) -> list[int]:
    return [number_in(video.frame(index)) for index in order]


def assert_every_frame_is_itself(path: Path, count: int) -> None:
    """Forward, backward and in a mixed order, with room for everything and for nothing."""
    with Video.open(path) as video:
        assert video.info.frame_count == count
        assert [number_in(p) for _, p in video.frames(0, count) if p is not None] == [*range(count)]
    mixed = np.random.default_rng(0).permutation(count)[:12].tolist()
    order = [count - 1, 0, count - 2, 1, *mixed, *range(count - 1, count - 6, -1)]
    with Video.open(path, cache_bytes=0) as video:
        assert numbers(video, order) == order
        assert video.missing == ()


# --- frames by number -------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "how"),
    [
        ("long_gop.mp4", {"options": LONG_GOP}),
        ("short_gop.mp4", {"options": {"bf": "2", "g": "5"}}),
        ("open_gop.mp4", {"options": {"x264-params": "open-gop=1:keyint=12:bframes=3"}}),
        ("all_keys.mov", {"options": {"g": "1"}}),
        ("clip.mkv", {"options": LONG_GOP}),
        ("clip.ts", {"options": {"bf": "3", "g": "20"}}),
        ("clip.mpg", {"codec": "mpeg2video", "options": {"bf": "2", "g": "12"}}),
        ("clip.webm", {"codec": "libvpx-vp9", "options": {"cpu-used": "8", "lag-in-frames": "16"}}),
        ("clip.avi", {"codec": "mjpeg", "pixels": "yuvj420p"}),
        ("b_frames.avi", {"codec": "mpeg4", "options": {"bf": "2", "g": "12"}}),
        ("ten_bit.mp4", {"pixels": "yuv420p10le"}),
        ("grey.mkv", {"codec": "ffv1", "pixels": "gray"}),
        ("alpha.mov", {"codec": "png", "pixels": "rgba"}),
        ("anim.gif", {"codec": "gif", "pixels": "rgb8", "rate": 25}),
    ],
)
def test_every_frame_is_found_by_its_number_in_any_order(
    tmp_path: Path, name: str, how: dict[str, Any]
) -> None:
    assert_every_frame_is_itself(write_numbered(tmp_path / name, 45, **how), 45)


def test_frames_without_times_are_numbered_as_they_are_decoded(tmp_path: Path) -> None:
    path = write_numbered(tmp_path / "bare.h264", 45, options={"bf": "3", "g": "20"})
    assert_every_frame_is_itself(path, 45)


def test_every_frame_of_a_variable_rate_file_has_its_own_number(tmp_path: Path) -> None:
    pts = [number * 3000 + number * 7919 % 700 + (number // 10) * 9000 for number in range(45)]
    path = write_numbered(
        tmp_path / "phone.mp4", 45, options=LONG_GOP, pts=pts, time_base=Fraction(1, 90000)
    )
    assert_every_frame_is_itself(path, 45)
    with Video.open(path) as video:
        assert video.info.variable_rate
        expected = (np.array(pts) - pts[0]) / 90000
        np.testing.assert_allclose(video.info.times_s, expected, atol=1e-4)


def test_frames_of_odd_size_keep_their_last_row_and_column(tmp_path: Path) -> None:
    pictures = [numbered_picture(number, 37, 29) for number in range(5)]
    path = write_clip(tmp_path / "odd.mp4", pictures, pixels="yuv444p")
    with Video.open(path) as video:
        assert video.frame(3).shape == (29, 37, 3)
        assert numbers(video, [4, 0, 3]) == [4, 0, 3]


def test_a_step_gives_every_nth_frame(tmp_path: Path) -> None:
    path = write_numbered(tmp_path / "clip.mp4", 30)
    with Video.open(path) as video:
        found = [(number, number_in(p)) for number, p in video.frames(4, 25, 5) if p is not None]
        assert found == [(4, 4), (9, 9), (14, 14), (19, 19), (24, 24)]
        assert list(video.frames(30, 30)) == []


def test_frames_asked_for_while_walking_do_not_disturb_the_walk(tmp_path: Path) -> None:
    path = write_numbered(tmp_path / "clip.mp4", 30, options={"g": "10"})
    with Video.open(path, cache_bytes=0) as video:
        for number, picture in video.frames(0, 30):
            assert picture is not None
            assert number_in(picture) == number
            assert number_in(video.frame(29 - number)) == 29 - number


def test_walking_forward_never_starts_over(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = write_numbered(tmp_path / "clip.mp4", 40, options={"g": "10"})
    with Video.open(path) as video:
        starts: list[int] = []
        start = decode_module.FileSource._start

        def counted(source: decode_module.FileSource, origin: int) -> Any:
            starts.append(origin)
            return start(source, origin)

        monkeypatch.setattr(decode_module.FileSource, "_start", counted)
        assert len(list(video.frames(0, 40))) == 40
        assert starts == [0]


def test_scrubbing_back_over_what_was_decoded_on_the_way_decodes_nothing(tmp_path: Path) -> None:
    path = write_numbered(tmp_path / "clip.mp4", 40, options=LONG_GOP)
    with Video.open(path) as video:
        video.frame(39)
        path.unlink()  # nothing can be decoded from the start any more
        assert numbers(video, [*range(38, -1, -1)]) == [*range(38, -1, -1)]


@pytest.mark.parametrize("name", ["clip.mp4", "turned.mp4", "folder"])
def test_a_shrunk_picture_is_of_the_frame_asked_for_and_as_upright(
    tmp_path: Path, name: str
) -> None:
    pictures = [numbered_picture(number, 128, 96) for number in range(12)]
    if name == "folder":
        path = tmp_path / name
        path.mkdir()
        for number, picture in enumerate(pictures):
            write_image(path / f"{number}.png", picture)
    else:
        path = write_clip(tmp_path / name, pictures, turn=(180,) if "turned" in name else None)
    with Video.open(path) as video:
        for number in (7, 3, 8):
            whole, half = video.frame(number), video.frame(number, shrink=2)
            assert half.shape == (48, 64, 3)
            assert not half.flags.writeable
            averaged = cv2.resize(whole, (64, 48), interpolation=cv2.INTER_AREA)
            np.testing.assert_array_equal(half, averaged)
            np.testing.assert_array_equal(video.frame(number), whole)


@pytest.fixture(scope="module")
def short_gop_clip(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("clip") / "clip.mp4"
    return write_numbered(path, 40, options={"bf": "2", "g": "9"})


@settings(
    max_examples=15,
    derandomize=True,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(order=st.lists(st.integers(0, 39), max_size=12), cache_bytes=st.sampled_from([0, 50_000]))
def test_no_history_of_requests_changes_what_a_number_means(
    short_gop_clip: Path, order: list[int], cache_bytes: int
) -> None:
    with Video.open(short_gop_clip, cache_bytes=cache_bytes) as video:
        assert numbers(video, order) == order


def test_threads_may_share_a_video(short_gop_clip: Path) -> None:
    found: dict[int, list[int]] = {}
    with Video.open(short_gop_clip, cache_bytes=0) as video:

        def read(first: int) -> None:
            found[first] = numbers(video, [*range(first, 40, 4)])

        threads = [threading.Thread(target=read, args=(first,)) for first in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    assert found == {first: [*range(first, 40, 4)] for first in range(4)}


def test_the_cache_stays_within_its_bytes_and_forgets_the_oldest() -> None:
    cache = PictureCache(byte_limit=3 * 300)
    pictures = {number: np.zeros((10, 10, 3), np.uint8) for number in range(5)}
    for number in (0, 1, 2):
        cache.put((number, 1), pictures[number])
    cache.get((0, 1))
    cache.put((3, 1), pictures[3])
    assert [number for number in range(5) if cache.get((number, 1)) is not None] == [0, 2, 3]


# --- what is told of a video ------------------------------------------------------------------


def test_a_video_gives_its_facts(tmp_path: Path) -> None:
    path = write_numbered(tmp_path / "clip.mp4", 30, rate=25)
    with Video.open(path) as video:
        info = video.info
    assert (info.path, info.container, info.codec) == (path, "mov", "h264")
    assert (info.width, info.height, info.frame_count) == (64, 48, 30)
    assert (info.fps, info.variable_rate, info.interlaced) == (25.0, False, False)
    assert (info.rotation_deg, info.pixel_aspect, info.missing) == (0, Fraction(1), ())
    np.testing.assert_allclose(info.times_s, np.arange(30) / 25)
    assert info.pts.dtype == np.int64
    assert not info.pts.flags.writeable
    assert not info.times_s.flags.writeable


def test_a_clock_that_rounds_to_milliseconds_is_not_a_variable_rate(tmp_path: Path) -> None:
    with Video.open(write_numbered(tmp_path / "clip.mkv", 30, rate=60)) as video:
        assert not video.info.variable_rate
        assert video.info.fps == 60.0


def test_pictures_are_eight_bit_and_cannot_be_written_to(tmp_path: Path) -> None:
    with Video.open(write_numbered(tmp_path / "clip.mp4", 3)) as video:
        picture = video.frame(1)
        assert picture.shape == (48, 64, 3)
        assert picture.dtype == np.uint8
        assert not picture.flags.writeable


def test_colours_come_back_as_red_green_and_blue(tmp_path: Path) -> None:
    picture = np.zeros((48, 64, 3), np.uint8)
    picture[:, :32, 0] = 255
    picture[:, 32:, 2] = 255
    path = write_clip(tmp_path / "clip.mp4", [picture] * 3, pixels="yuv444p")
    with Video.open(path) as video:
        np.testing.assert_allclose(video.frame(1)[24, 8], (255, 0, 0), atol=8)
        np.testing.assert_allclose(video.frame(1)[24, 56], (0, 0, 255), atol=8)


@pytest.mark.parametrize(
    ("turn", "upright", "rotation_deg", "mirrored"),
    [
        ((90,), lambda stored: np.rot90(stored, 1), 90, ""),
        ((-90,), lambda stored: np.rot90(stored, -1), 270, ""),
        ((180,), lambda stored: np.rot90(stored, 2), 180, ""),
        ((0, False, True), lambda stored: stored[::-1], 0, "top to bottom"),
        ((0, True, False), lambda stored: stored[:, ::-1], 0, "left to right"),
        ((0, True, True), lambda stored: stored[::-1, ::-1], 180, ""),
        ((90, True, False), lambda stored: np.rot90(stored, 1)[:, ::-1], 90, "left to right"),
        ((-90, True, False), lambda stored: np.rot90(stored, -1)[:, ::-1], 270, "left to right"),
    ],
)
def test_rotation_and_mirroring_are_applied_once(
    tmp_path: Path,
    turn: tuple[Any, ...],
    upright: Callable[[np.ndarray[Any, Any]], np.ndarray[Any, Any]],
    rotation_deg: int,
    mirrored: str,
) -> None:
    stored = [numbered_picture(number) for number in range(4)]
    path = write_clip(tmp_path / "turned.mp4", stored, turn=turn)
    with Video.open(path) as video:
        for number, picture in enumerate(decoded_plainly(path)):
            np.testing.assert_array_equal(video.frame(number), upright(picture))
        assert (video.info.height, video.info.width) == video.frame(0).shape[:2]
        assert (video.info.rotation_deg, video.info.mirrored) == (rotation_deg, mirrored)


def test_a_copy_has_the_same_fingerprint_and_another_video_has_not(tmp_path: Path) -> None:
    one = write_numbered(tmp_path / "one.mp4", 10)
    copy = Path(shutil.copy(one, tmp_path / "copy.mp4"))
    other = write_clip(tmp_path / "other.mp4", [numbered_picture(n + 1) for n in range(10)])
    prints = []
    for path in (one, copy, other):
        with Video.open(path) as video:
            prints.append(video.fingerprint())
    assert prints[0] == prints[1] != prints[2]
    assert prints[0].startswith("sha256:")


@pytest.mark.parametrize(
    ("name", "codec"),
    [
        ("clip.mp4", "libx264"),
        ("clip.mov", "libx264"),
        ("clip.mkv", "libx264"),
        ("clip.avi", "mpeg4"),
    ],
)
def test_a_film_opens_whatever_letters_its_title_and_artist_are_in(
    tmp_path: Path, name: str, codec: str
) -> None:
    path = write_with_foreign_tags(tmp_path / name, 12, codec=codec)
    with pytest.raises(UnicodeDecodeError):
        av.open(str(path))
    assert_every_frame_is_itself(path, 12)


@pytest.mark.parametrize(
    "error",
    [
        UnicodeDecodeError("utf-8", b"\xe9", 0, 1, "invalid"),
        ValueError("not a pixel format"),
        OverflowError("too large"),
        av.error.InvalidDataError(1, "invalid"),
    ],
)
def test_whatever_pyav_raises_on_opening_is_one_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception
) -> None:
    path = write_numbered(tmp_path / "clip.mp4", 3)
    folder = write_folder(tmp_path / "shots", ["1.png"])

    def fails(*_: object, **__: object) -> None:
        raise error

    monkeypatch.setattr("keypose.tracker.video.container.av.open", fails)
    for place in (path, folder):
        with pytest.raises(VideoError, match=r"^[^\n]+\.$"):
            Video.open(place)


def test_a_picture_that_pyav_cannot_convert_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_numbered(tmp_path / "clip.mp4", 3)
    folder = write_folder(tmp_path / "shots", ["1.png", "2.png"])

    def fails(*_: object) -> None:
        raise ValueError("no such conversion")

    for place in (path, folder):
        with Video.open(place) as video, monkeypatch.context() as broken:
            broken.setattr("keypose.tracker.video.picture.PictureMaker.picture", fails)
            with pytest.raises(MissingFrame):
                video.frame(1)


# --- damage -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["clip.mov", "clip.avi", "clip.mkv"])
@pytest.mark.parametrize("lost", [0, 12, 19])
def test_a_frame_that_cannot_be_decoded_keeps_its_number(
    tmp_path: Path, name: str, lost: int
) -> None:
    path = write_numbered(tmp_path / name, 20, codec="mjpeg", pixels="yuvj420p")
    damage_packet(path, lost)
    with Video.open(path) as video:
        found = [None if p is None else number_in(p) for _, p in video.frames(0, 20)]
        assert found == [None if number == lost else number for number in range(20)]
        assert video.missing == video.info.missing == (lost,)
        assert video.info.frame_count == 20
    with Video.open(path) as video:
        assert numbers(video, [15, 3]) == [15, 3]
        with pytest.raises(MissingFrame, match=rf'^Frame {lost} of "{name}" is damaged .*\.$'):
            video.frame(lost)


def test_an_index_that_left_out_a_frame_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_numbered(tmp_path / "clip.mp4", 20)

    def one_short(container: Any, stream: Any) -> Any:
        index = index_from_packets(container, stream)
        assert index is not None
        return replace(index, pts=np.delete(index.pts, 7))

    monkeypatch.setattr("keypose.tracker.video.decode.index_from_packets", one_short)
    with Video.open(path) as video:
        assert video.info.frame_count == 19
        assert [number_in(p) for _, p in video.frames(0, 19) if p is not None] == [*range(19)]
        assert video.info.frame_count == 20
        assert numbers(video, [19, 7]) == [19, 7]


@pytest.mark.parametrize("cut", [1, 12, 13, 25])
@pytest.mark.parametrize("codec", [{"bf": "3", "g": "12"}, LONG_GOP], ids=["keys", "one key"])
def test_a_film_that_was_cut_on_a_phone_is_opened_without_decoding_and_begins_at_the_cut(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cut: int, codec: dict[str, str]
) -> None:
    whole = write_numbered(tmp_path / "whole.mp4", 40, options=codec)
    path = write_cut(tmp_path / "cut.mp4", whole, cut)
    decoded = index_from_decoding(path)

    def never(path: Path, threaded: bool = True) -> None:
        raise AssertionError("decoded")

    monkeypatch.setattr("keypose.tracker.video.decode.index_from_decoding", never)
    order = [3, 0, 39 - cut, 7, 1, *np.random.default_rng(0).permutation(40 - cut).tolist()]
    with Video.open(path, cache_bytes=0) as video:
        np.testing.assert_array_equal(video.info.pts, decoded.pts)
        assert video.info.frame_count == 40 - cut
        assert [number - cut for number in numbers(video, order)] == order
        deque(video.examine(0, 39 - cut), maxlen=0)
        assert video.info.damaged == video.missing == ()


PIECES = {
    "the end cut": ([(0, 20)], False), "both ends cut": ([(7, 20)], False),
    "two": ([(3, 10), (25, 10)], True), "the later one first": ([(24, 12), (5, 12)], True),
    "one twice": ([(5, 10), (5, 10)], True),
}  # fmt: skip


@pytest.mark.parametrize("name", PIECES)
def test_a_film_of_several_pieces_is_numbered_as_it_is_decoded(tmp_path: Path, name: str) -> None:
    pieces, is_decoded = PIECES[name]
    options = {"bf": "2", "g": "12", "sc_threshold": "0"}
    whole = write_numbered(tmp_path / "whole.mp4", 40, options=options)
    path = write_pieces(tmp_path / "pieces.mp4", whole, pieces)
    expected = index_from_decoding(path)
    with av.open(str(path)) as container:
        known = index_from_packets(container, container.streams.video[0])
    assert (known is None) == is_decoded
    with Video.open(path) as video:
        np.testing.assert_array_equal(video.info.pts, expected.pts)
        if not is_decoded:
            first, count = pieces[0]
            assert numbers(video, [*range(count)]) == [*range(first, first + count)]


@pytest.mark.parametrize("cut", [0, 5, 12, 17])
@pytest.mark.parametrize("reordered", ["0", "2", "5"])
def test_a_jump_decodes_from_the_key_before_on_also_in_a_film_that_was_cut(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cut: int, reordered: str
) -> None:
    options = {"bf": reordered, "g": "16", "sc_threshold": "0"}
    whole = write_numbered(tmp_path / "whole.mp4", 60, options=options)
    path = write_cut(tmp_path / "cut.mp4", whole, cut) if cut else whole
    given = 0

    def counted(stream: Any, packet: Any) -> Any:
        nonlocal given
        given += 1
        return decode(stream, packet)

    monkeypatch.setattr("keypose.tracker.video.container.decode", counted)
    with Video.open(path, cache_bytes=0) as video:
        for wanted in (34, 51, 33):
            given = 0
            assert number_in(video.frame(wanted - cut)) == wanted
            assert 0 < given <= wanted % 16 + 12  # those it is built on come first


def test_a_file_cut_short_gives_the_frames_it_still_holds(tmp_path: Path) -> None:
    path = write_numbered(tmp_path / "cut.mkv", 60, options={"g": "12"})
    content = path.read_bytes()
    path.write_bytes(content[: len(content) * 6 // 10])
    with Video.open(path) as video:
        count = video.info.frame_count
        assert 10 < count < 60
        found = [(number, p) for number, p in video.frames(0, count) if p is not None]
        filmed = np.round(video.info.times_s * 30)
        assert [number_in(p) for _, p in found] == [filmed[number] for number, _ in found]
        assert len(found) >= count - 1


# --- folders of images ------------------------------------------------------------------------


def write_folder(folder: Path, names: list[str]) -> Path:
    folder.mkdir()
    for number, name in enumerate(names):
        write_image(folder / name, numbered_picture(number))
    return folder


def test_images_are_frames_in_natural_order(tmp_path: Path) -> None:
    names = ["frame_1.png", "frame_2.png", "frame_10.png", "frame_010b.png", "frame_100.PNG"]
    folder = write_folder(tmp_path / "shots", names)
    (folder / "notes.txt").write_text("not an image")
    (folder / "._frame_1.png").write_bytes(b"left by a file manager")
    with Video.open(folder) as video:
        assert numbers(video, [4, 0, 3, 1, 2]) == [4, 0, 3, 1, 2]
        assert (video.info.container, video.info.frame_count) == ("images", 5)
        assert video.info.times_s[1] == pytest.approx(1 / 30)


@pytest.mark.parametrize(
    ("codec", "pixels", "suffix"),
    [
        ("mjpeg", "yuvj420p", "jpg"),
        ("bmp", "bgr24", "bmp"),
        ("tiff", "rgb24", "tif"),
        ("png", "gray16be", "png"),
        ("png", "rgba", "png"),
    ],
)
def test_images_of_every_common_kind_are_read_whatever_they_are_called(
    tmp_path: Path, codec: str, pixels: str, suffix: str
) -> None:
    for number, stem in enumerate(["a %03d", "b*"]):
        picture = numbered_picture(number)
        write_image(tmp_path / f"{stem}.{suffix}", picture, codec=codec, pixels=pixels)
    with Video.open(tmp_path) as video:
        assert numbers(video, [1, 0]) == [1, 0]


def test_a_photograph_is_turned_as_the_camera_noted(tmp_path: Path) -> None:
    path = write_image(tmp_path / "1.jpg", numbered_picture(1), codec="mjpeg", pixels="yuvj420p")
    (stored,) = decoded_plainly(path)
    ask_for_turn(path, 6)  # a quarter turn clockwise
    with Video.open(tmp_path) as video:
        np.testing.assert_array_equal(video.frame(0), np.rot90(stored, -1))
        assert (video.info.width, video.info.height) == (48, 64)


def test_an_image_that_cannot_be_read_keeps_its_number(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "shots", [f"{number}.png" for number in range(4)])
    for number in (0, 2):
        (folder / f"{number}.png").write_bytes(b"no picture")
    with Video.open(folder) as video:
        assert [number for number, p in video.frames(0, 4) if p is None] == [0, 2]
        assert numbers(video, [3, 1]) == [3, 1]
        assert video.missing == (0, 2)


def test_images_of_different_sizes_are_refused_by_name(tmp_path: Path) -> None:
    folder = write_folder(tmp_path / "shots", ["a.png", "b.png"])
    write_image(folder / "c.png", numbered_picture(2, 32, 24))
    with pytest.raises(VideoError, match=r'"a.png" is 64 × 48 and "c.png" is 32 × 24'):
        Video.open(folder)


@pytest.mark.parametrize(
    ("brightest", "depth"), [(1023, 10), (4080, 12), (9000, 14), (16384, None)]
)
@pytest.mark.parametrize("channels", [1, 3, 4])
def test_bits_that_are_used_of_sixteen_are_spread_alike_for_a_whole_folder(
    tmp_path: Path, brightest: int, depth: int | None, channels: int
) -> None:
    shape = (4, 6) if channels == 1 else (4, 6, channels)
    for number, value in enumerate((brightest // 2, brightest)):
        values = np.full(shape, value, np.uint16)
        if channels == 4:
            values[..., 3] = 0xFFFF
        assert cv2.imwrite(str(tmp_path / f"{number}.png"), values)
    with Video.open(tmp_path) as video:
        assert video.info.depth == depth
        seen = [picture.mean() for _, picture in video.frames(0, 2) if picture is not None]
    full = (1 << (depth or 16)) - 1
    assert seen == pytest.approx([255 * brightest / 2 / full, 255 * brightest / full], abs=1.5)


@pytest.mark.parametrize(
    ("names", "words"),
    [
        (["1", "2", "3"], ""),
        (["a0002", "a0004", "a0006"], ""),
        (["a", "b"], ""),
        (["run", "1", "3"], ""),
        (["20240101120000", "20240101120107", "20240101120351"], ""),
        (["1", "2", "4", "8", "9"], "Image numbers 3 and 5–7 missing"),
        (["0", "2", "4", "8"], "Image numbers 6 missing"),
        (["a1", "a2", "a02", "a3", "a5"], "Image numbers 4 missing, 2 doubled"),
        (["9" * 30, "1"], ""),
    ],
)
def test_numbers_that_are_missing_or_doubled_among_images_are_told(
    tmp_path: Path, names: list[str], words: str
) -> None:
    folder = write_folder(tmp_path / "shots", [f"{name}.png" for name in names])
    with Video.open(folder) as video:
        told = f"{words}: the images are read as consecutive frames." if words else ""
        assert video.info.numbering == told


def test_a_folder_is_fingerprinted_by_its_images(tmp_path: Path) -> None:
    one = write_folder(tmp_path / "one", ["1.png", "2.png"])
    two = write_folder(tmp_path / "two", ["1.png", "2.png"])
    prints = [Video.open(folder).fingerprint() for folder in (one, two)]
    write_image(two / "2.png", numbered_picture(9))
    prints.append(Video.open(two).fingerprint())
    assert prints[0] == prints[1] != prints[2]


# --- one plain sentence -----------------------------------------------------------------------


def _unknown_codec(folder: Path) -> Path:
    path = write_numbered(folder / "strange.mp4", 3)
    path.write_bytes(path.read_bytes().replace(b"avc1", b"zzzz"))
    return path


def _without_moov(folder: Path) -> Path:
    path = write_numbered(folder / "cut.mp4", 30)
    path.write_bytes(path.read_bytes().partition(b"moov")[0][:-4])
    return path


def _playlist(folder: Path) -> Path:
    clip = write_numbered(folder / "secret.ts", 10)
    content = f"#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\n{clip}\n#EXT-X-ENDLIST\n"
    return _written(folder / "list.mp4", content.encode())


def _fifo(folder: Path) -> Path:
    os.mkfifo(folder / "pipe.mp4")
    return folder / "pipe.mp4"


def _unread(folder: Path, *names: str) -> Path:
    for name in names:
        _written(folder / name, b"no matter")
    return folder


def _written(path: Path, content: bytes) -> Path:
    path.write_bytes(content)
    return path


BAD_FILES: dict[str, Callable[[Path], Path]] = {
    "There is no file": lambda folder: folder / "absent.mp4",
    "is empty": lambda folder: _written(folder / "empty.mp4", b""),
    "is not a video": lambda folder: _written(folder / "page.mp4", b"<html>not here</html>"),
    '"noise.mp4" is not a video': lambda folder: _written(
        folder / "noise.mp4", np.random.default_rng(0).bytes(50_000)
    ),
    '"list.mp4" is not a video': _playlist,
    "sound but no pictures": lambda folder: write_sound(folder / "song.m4a"),
    "cannot decode": _unknown_codec,
    "is incomplete": _without_moov,
    "holds no images": lambda folder: folder,
    "neither a file nor a folder": _fifo,
    "not read, 2 of OpenEXR:": lambda folder: _unread(folder, "s.1001.exr", "s.1002.EXR"),
    "not read, 1 of DPX and 1 of raw": lambda folder: _unread(folder, "a.dpx", "b.nef", ".c.dpx"),
    "not read, OpenEXR: put all": lambda folder: _written(folder / "s.1001.exr", b"v/1\x01" * 20),
    "not read, HEIC: put all": lambda folder: _written(folder / "i.HEIC", b"\0\0\0\x18ftypheic"),
}


@pytest.mark.parametrize("complaint", BAD_FILES)
def test_what_is_no_video_is_refused_in_one_plain_sentence(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], complaint: str
) -> None:
    path = BAD_FILES[complaint](tmp_path)
    capfd.readouterr()
    with pytest.raises(VideoError, match=complaint) as refused:
        Video.open(path)
    assert_one_sentence(str(refused.value), path)
    assert capfd.readouterr() == ("", "")


def assert_one_sentence(text: str, path: Path) -> None:
    assert f'"{path.name}"' in text or f'"{path}"' in text
    assert ": " in text  # what is wrong, then what to do
    assert text.endswith(".")
    assert "\n" not in text
    assert ". " not in text.replace(path.name, "")
    assert "Errno" not in text


def test_a_video_that_may_not_be_read_is_refused_in_one_plain_sentence(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = write_numbered(tmp_path / "private.mp4", 3)

    def refuse(*_: object, **__: object) -> None:
        raise av.error.PermissionError(13, "Permission denied", str(path))

    monkeypatch.setattr(av, "open", refuse)
    with pytest.raises(VideoError, match="may not be read") as refused:
        Video.open(path)
    assert_one_sentence(str(refused.value), path)


@pytest.mark.parametrize("index", [-1, 5, 10**9])
def test_a_frame_outside_the_video_is_refused_with_the_valid_range(
    tmp_path: Path, index: int
) -> None:
    with Video.open(write_numbered(tmp_path / "clip.mp4", 5)) as video:
        with pytest.raises(VideoError, match=rf"no frame {index}: choose one between 0 and 4\."):
            video.frame(index)
        with pytest.raises(VideoError, match="between 0 and 4"):
            video.frames(0, 6)
        with pytest.raises(VideoError, match="choose 1 or more"):
            video.frames(0, 5, 0)


def test_a_closed_video_says_so(tmp_path: Path) -> None:
    video = Video.open(write_numbered(tmp_path / "clip.mp4", 5))
    video.frame(2)
    video.close()
    with pytest.raises(VideoError, match="has been closed"):
        video.frame(2)


# --- real files, good and bad -----------------------------------------------------------------

# Of the person clip: how many frames each holds.
READABLE = {
    "anamorphic_sar2.mp4": 40,
    "anim.gif": 8,
    "audio_longer_than_video.mp4": 40,
    "av1.mp4": 40,
    "fps1000.mp4": 666,
    "gray_ffv1.mkv": 10,
    "hevc_10bit.mp4": 40,
    "hevc_8bit.mp4": 40,
    "interlaced_mpeg2.mpg": 18,
    "long_gop_bframes.mp4": 60,
    "mjpeg_fullrange.avi": 40,
    "one_frame.mp4": 1,
    "prores422hq_10bit.mov": 6,
    "rot180_meta.mov": 40,
    "tiny_17x31.mp4": 40,
    "vfr_h264.mp4": 54,
    "vp9.webm": 40,
    "日本語 名前 & 'quote'.mp4": 40,
}
# In these a picture is another number of the clip, or too small to tell one from the next.
NOT_NUMBERED_LIKE_THE_CLIP = {"anim.gif", "fps1000.mp4", "interlaced_mpeg2.mpg", "tiny_17x31.mp4"}
UNREADABLE = [
    "audio_only.mp4",
    "empty.mp4",
    "html_named.mp4",
    "random_bytes.mp4",
    "truncated_no_moov_tail.mp4",
    "zero_frames.mp4",
]


def shared(name: str) -> Path:
    path = SHARED / name
    if not path.exists():
        pytest.skip(f"{name} is not beside the checkout")
    return path


def thumbnail(picture: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """(120, 68) brightness, by which frames of the clip are told apart whatever their size."""
    grey = av.VideoFrame.from_ndarray(np.ascontiguousarray(picture), format="rgb24").reformat(
        width=68, height=120, format="gray", interpolation="AREA", threads=1
    )
    return grey.to_ndarray().astype(np.float32)


@pytest.fixture(scope="module")
def clip_thumbnails() -> Iterator[np.ndarray[Any, Any]]:
    with Video.open(shared("person/cam03_544x960.mp4")) as video:
        yield np.stack([thumbnail(p) for _, p in video.frames(0, 100) if p is not None])


def number_in_clip(picture: np.ndarray[Any, Any], thumbnails: np.ndarray[Any, Any]) -> int:
    return int(np.abs(thumbnails - thumbnail(picture)).mean(axis=(1, 2)).argmin())


@pytest.mark.parametrize("name", READABLE)
def test_every_readable_file_gives_the_same_frames_forward_and_at_random(name: str) -> None:
    path, count = shared(f"broken_videos/{name}"), READABLE[name]
    truth = decoded_plainly(path)
    turned = "rot180" in name
    expected = [p[::-1, ::-1] if turned else p for p in truth]
    with Video.open(path, deinterlace=False) as video:
        assert video.info.frame_count == count == len(truth)
        assert video.info.rotation_deg == (180 if turned else 0)
        assert video.info.interlaced == ("interlaced" in name)
        assert video.info.variable_rate == ("vfr" in name)
        assert video.info.pixel_aspect == (2 if "sar2" in name else 1)
        for number, picture in video.frames(0, count):
            np.testing.assert_array_equal(picture, expected[number])
    order = [count - 1, 0, *np.random.default_rng(0).integers(0, count, 10).tolist()]
    with Video.open(path, cache_bytes=0, deinterlace=False) as video:
        for number in [*order, *sorted(order, reverse=True)[:4]]:
            np.testing.assert_array_equal(video.frame(number), expected[number])
        assert video.missing == ()


@pytest.mark.parametrize("name", sorted(READABLE.keys() - NOT_NUMBERED_LIKE_THE_CLIP))
def test_frame_n_of_a_real_file_shows_what_was_filmed_at_its_time(
    name: str, clip_thumbnails: np.ndarray[Any, Any]
) -> None:
    with Video.open(shared(f"broken_videos/{name}")) as video:
        for number, picture in video.frames(0, video.info.frame_count, 3):
            assert picture is not None
            upright = picture[::-1, ::-1] if video.info.rotation_deg else picture
            filmed = round(video.info.times_s[number] * 60)
            assert number_in_clip(upright, clip_thumbnails) == filmed


@pytest.mark.parametrize("name", UNREADABLE)
def test_every_unreadable_file_is_refused_in_one_plain_sentence(
    name: str, capfd: pytest.CaptureFixture[str]
) -> None:
    path = shared(f"broken_videos/{name}")
    with pytest.raises(VideoError) as refused:
        Video.open(path)
    assert_one_sentence(str(refused.value), path)
    assert capfd.readouterr() == ("", "")


def test_flipped_bits_leave_frames_missing_but_never_shifted(
    clip_thumbnails: np.ndarray[Any, Any],
) -> None:
    path = shared("broken_videos/bitflips_light.mp4")
    with Video.open(path) as video, Video.open(shared("person/cam03_544x960.mp4")) as clean:
        found = [p for _, p in video.frames(0, 100)]
        assert len(found) == video.info.frame_count == 100
        np.testing.assert_array_equal(video.info.times_s, clean.info.times_s)
        assert video.missing == tuple(n for n, p in enumerate(found) if p is None) != ()
        for number in range(3):  # before the first flipped bit
            np.testing.assert_array_equal(found[number], clean.frame(number))
        for number in range(49):  # later the damage hides the man
            picture = found[number]
            assert picture is None or number_in_clip(picture, clip_thumbnails) == number
    with Video.open(path) as again:
        assert [n for n in (99, 50, 6, 30) if _is_missing(again, n)] == [50, 6]
        for number in (99, 30, 60):
            np.testing.assert_array_equal(again.frame(number), found[number])


def _is_missing(video: Video, number: int) -> bool:
    try:
        video.frame(number)
    except MissingFrame:
        return True
    return False


def test_any_frame_of_an_hour_is_the_right_one() -> None:
    path = shared("broken_videos/long_1h_108000frames.mp4")
    wanted = {107_999, 0, 54_000, 53_999, *np.random.default_rng(0).integers(0, 108_000, 8)}
    truth = {}
    with av.open(str(path)) as container:
        container.streams.video[0].thread_type = "AUTO"
        for number, frame in enumerate(container.decode(video=0)):
            if number in wanted:
                truth[number] = frame.to_ndarray(format="rgb24", threads=1)
    with Video.open(path, cache_bytes=1_000_000) as video:
        assert (video.info.frame_count, video.info.fps) == (108_000, 30.0)
        for number in sorted(truth, reverse=True):
            np.testing.assert_array_equal(video.frame(number), truth[number])
