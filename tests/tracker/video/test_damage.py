"""Damaged frames are known as such, and those of undamaged films never are."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import av
import pytest

from keypose.tracker.errors import VideoError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.video import Video
from keypose.tracker.video.clip_loader import ClipLoader, WorkingSize
from keypose.tracker.video.consumption import Coding, is_misread
from keypose.tracker.video.damage import Examined, examine
from keypose.tracker.video.pyramid import IGNORED
from keypose.tracker.video.vp9 import inner_tiles
from tests.tracker.damage_cases import (
    COUNT,
    FILMS,
    FLAT,
    HEIGHT,
    WIDTH,
    FilmKind,
    Tally,
    examined,
    greys,
    mutants,
    write_film,
)
from tests.tracker.video_cases import flip_bit, numbered_picture, write_image, write_numbered

SAMPLES = sorted((Path(__file__).parents[3] / "sample_videos").glob("*/*.mp4"))
MUTANTS = 8
"""Of each of ten films."""
SIZES = ((352, 192), (480, 144))
"""Of films. VP9 has two tiles from a width of 449 on."""
KNOWN = 0.98
"""Share of the wrong frames that is known at least. A single mutant whose packet holds together by
chance hides up to eight of them."""

ODD = (
    FilmKind("refreshed.mp4", options={"x264-params": "intra-refresh=1:keyint=10"}),
    FilmKind("interlaced.mp4", options={"x264-params": "tff=1:keyint=10"}),
    FilmKind("interlaced.mpg", "mpeg2video", {"flags": "+ildct+ilme", "g": "10", "bf": "2"}),
    FilmKind("long_gop.mkv", options={"x264-params": "keyint=250:bframes=5:b-pyramid=normal"}),
    FilmKind(
        "open_gop_hevc.mkv", "libx265", {"x265-params": "keyint=10:open-gop=1:log-level=none"}
    ),
    FilmKind("ten_bit.mp4", pixels="yuv420p10le"),
    FilmKind("bare.h264", options={"g": "10"}),
    FilmKind("motion.avi", "mjpeg", pixels="yuvj420p"),
    FilmKind("lossless.mkv", "ffv1"),
    FilmKind("turned.ts", options={"g": "10", "bf": "2"}),
    FilmKind("flash.flv", "flv1"),
    FilmKind("phone.mp4", "mpeg4", {"g": "5", "flags": "+aic"}),
    FilmKind("woven.avi", "mpeg4", {"g": "5", "flags": "+ildct+ilme", "bf": "1"}),
    FilmKind("still.mp4", "libx265", {"x265-params": "keyint=12:crf=51:wpp=0:log-level=none"}),
    FilmKind("strips.mkv", "libx265", {"x265-params": "slices=3:keyint=8:log-level=none"}),
    FilmKind("stream.ts", "libx265", {"x265-params": "keyint=8:log-level=none"}),
    FilmKind("deep.mp4", "libx265", {"x265-params": "log-level=none"}, "yuv422p10le"),
    FilmKind("worst.mp4", options={"crf": "51", "g": "6"}),
    FilmKind("strips.mp4", options={"x264-params": "slices=4:keyint=6"}),
    FilmKind("strips.ts", options={"x264-params": "slices=4:keyint=6"}),
)

EXAMINED_TO_THE_END = (
    FilmKind("strips.mp4", options={"x264-params": "slices=2:keyint=6"}),
    FilmKind("strips.ts", options={"x264-params": "slices=4:cabac=0:keyint=6"}),
    FilmKind("keys.mp4", options={"g": "1", "preset": "slow", "crf": "10"}),
    FilmKind("strips.mkv", "libx265", {"x265-params": "slices=3:keyint=6:log-level=none"}),
    FilmKind("keys.webm", "libvpx-vp9", {"g": "1", "cpu-used": "8", "tile-columns": "2"}),
)
"""Films whose packets, or keys, are examined to their end."""


@pytest.mark.parametrize("kind", [*FILMS, *ODD], ids=lambda kind: kind.name)
def test_no_frame_of_an_undamaged_film_is_damaged(tmp_path: Path, kind: FilmKind) -> None:
    film = write_film(tmp_path, kind)
    with Video.open(film) as video:
        assert examined(video) == set()
    copied = film.with_stem("copied")
    copied.write_bytes(film.read_bytes())
    with Video.open(copied) as video:  # from the middle as well
        last = video.info.frame_count - 1
        assert list(video.examine(last // 2, last))[-1] == last
        assert (video.info.damaged, video.info.missing) == ((), ())


@pytest.mark.parametrize("kind", EXAMINED_TO_THE_END, ids=lambda kind: kind.name)
@pytest.mark.parametrize("content", FLAT)
def test_no_frame_is_damaged_because_it_shows_nothing(
    tmp_path: Path, content: str, kind: FilmKind
) -> None:
    with Video.open(write_film(tmp_path, kind, 480, 144, FLAT[content])) as video:
        assert examined(video) == set()


def test_what_is_damaged_is_found_once_for_all_who_open_a_film_until_it_is_another(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    film = write_numbered(tmp_path / "film.mp4", 30)
    decoded: list[Path] = []

    def counted(path: Path, *given: Any) -> Iterator[Examined]:
        decoded.append(path)
        return examine(path, *given)

    monkeypatch.setattr("keypose.tracker.video.decode.examine", counted)
    for expected in (1, 1, 1):
        with Video.open(film) as video:
            assert examined(video) == set()
            assert len(decoded) == expected
    with Video.open(film) as one, Video.open(film) as other:
        assert examined(one) == examined(other) == set()
    assert len(decoded) == 1
    write_numbered(film, 31)
    with Video.open(film) as one, Video.open(film) as other:  # both at once
        assert list(one.examine(0, 9))
        assert examined(other) == examined(one) == set()
    assert len(decoded) == 3


@pytest.mark.parametrize("film", SAMPLES, ids=lambda path: path.stem)
def test_no_frame_of_a_sample_is_damaged(film: Path) -> None:
    with Video.open(film) as video:
        assert examined(video) == set()


@pytest.mark.skipif(not hasattr(os, "sched_getscheduler"), reason="this system has no such calls")
def test_a_film_is_written_without_making_the_tests_a_real_time_process(tmp_path: Path) -> None:
    before = os.sched_getscheduler(0)
    for kind in FILMS:
        write_film(tmp_path, kind)
        assert os.sched_getscheduler(0) == before, kind.name


def test_an_encoders_note_without_its_first_byte_is_no_damage(tmp_path: Path) -> None:
    """Some programs that cut films leave it out: what remains looks like a key's slice."""
    film = write_film(tmp_path, FilmKind("cut.mp4", options={"x264-params": _TENS}))
    with av.open(str(film)) as container:
        first = next(bytes(packet) for packet in container.demux(video=0))
    size = int.from_bytes(first[:4], "big")
    note = first[4 : 4 + size]
    assert b"x264" in note
    # An empty unit makes up for what is left out, so that the file stays as long.
    cut = (size - 5).to_bytes(4, "big") + note[1 : size - 4] + (1).to_bytes(4, "big") + b"\x0c"
    film.write_bytes(film.read_bytes().replace(first[: 4 + size], cut))
    with Video.open(film) as video:
        assert examined(video) == set()


@pytest.mark.parametrize(("width", "height"), SIZES)
def test_nearly_all_frames_that_are_seen_to_be_wrong_are_known(
    tmp_path: Path, width: int, height: int
) -> None:
    """The rest is in packets that hold together by chance: MPEG-4 finds back into its codes after
    the right number of blocks, and what stands between two keys of H.264, or in a tile of VP9
    that is not the last, cannot be decoded by itself."""
    tallies = {kind.name: _tally(write_film(tmp_path, kind, width, height)) for kind in FILMS}
    wrong, known = (sum(getattr(t, name) for t in tallies.values()) for name in ("wrong", "known"))
    assert wrong > 300
    assert known >= KNOWN * wrong, tallies


def test_wrong_frames_are_known_in_a_film_between_black_bars(tmp_path: Path) -> None:
    """The ends of its packets show nothing."""
    shown = FLAT["bars above and below"]
    kinds = [*EXAMINED_TO_THE_END[:2], *(k for k in FILMS if k.name in ("cabac.mp4", "hevc.mp4"))]
    tallies = {k.name: _tally(write_film(tmp_path, k, shown=shown)) for k in kinds}
    wrong, known = (sum(getattr(t, name) for t in tallies.values()) for name in ("wrong", "known"))
    assert wrong > 100
    assert known >= KNOWN * wrong, tallies


def _tally(film: Path) -> Tally:
    tally, sound = Tally(), greys(film)
    for mutant in mutants(film, MUTANTS):
        try:
            tally.add(mutant, sound)
        except VideoError:
            continue  # it does not open at all, which a person is told
    return tally


def test_a_tile_of_vp9_that_ends_with_zeros_is_read_to_its_end(tmp_path: Path) -> None:
    """Some encoders end a tile with the value that has most zeros of those that mean the same."""
    keys = {"g": "1", "cpu-used": "8", "b": "2000k", "tile-columns": "2"}
    film = write_film(tmp_path, FilmKind("keys.webm", "libvpx-vp9", keys), 480, 144)
    coding, judged = Coding("vp9", None), 0
    with av.open(str(film)) as container:
        for sound in filter(None, map(bytes, container.demux(video=0))):
            ended = bytearray(sound)
            for _, end in inner_tiles(sound):
                value = int.from_bytes(sound[end - 4 : end], "big")
                ended[end - 4 : end] = ((value >> 16) + 1 << 16 & 0xFFFFFFFF).to_bytes(4, "big")
            if picture_of(ended) == picture_of(sound):
                judged += 1
                assert not is_misread(bytes(ended), coding)
    assert judged >= 5


def picture_of(packet: bytes) -> bytes:
    """What one packet of VP9 shows by itself."""
    frames = av.CodecContext.create("vp9", "r").decode(av.Packet(packet))
    return b"".join(bytes(plane) for frame in frames for plane in frame.planes)


def test_damage_of_vp9_ends_with_the_next_key_as_that_of_others_does(tmp_path: Path) -> None:
    (kind,) = (kind for kind in FILMS if kind.codec == "libvpx-vp9")
    film, ends = write_film(tmp_path, kind), set[int]()
    for mutant in mutants(film, MUTANTS):
        with Video.open(mutant) as video:
            damaged = examined(video)
        ends |= {frame + 1 for frame in damaged if frame + 1 not in damaged}
    assert ends
    assert ends <= {12, 24, COUNT}
    assert ends & {12, 24}


@pytest.fixture
def broken(tmp_path: Path) -> Path:
    """30 frames with a key at every tenth, and a bit turned in the 14th."""
    path = write_film(tmp_path, FilmKind("clip.mp4", options={"x264-params": _TENS}))
    flip_bit(path, packet=13, byte=60)
    return path


_TENS = "keyint=10:min-keyint=10:scenecut=0:bframes=0"


def test_everything_after_damage_is_damaged_up_to_the_next_key(broken: Path) -> None:
    with Video.open(broken) as video:
        assert video.info.damaged == ()
        assert examined(video) == set(range(13, 20))


def test_damage_is_known_also_where_reading_meanwhile_shows_a_frame_to_be_missing(
    tmp_path: Path,
) -> None:
    path = tmp_path / "person.mp4"
    shutil.copy(next(sample for sample in SAMPLES if sample.name == path.name), path)
    # in the head of a slice, so that every decoder gives the frame up: of what is wrong behind it
    # several threads make a picture or none, by chance
    flip_bit(path, packet=32, byte=8)
    with Video.open(path) as video:
        for number in video.examine(0, 72):
            if number > 50 and not video.info.missing:
                assert set(video.info.damaged) == set(range(31, 48))
                assert [n for n, picture in video.frames(31, 32) if picture is None] == [31]
                assert video.info.missing == (31,)
        assert set(video.info.damaged) | set(video.info.missing) == set(range(31, 48))


def test_damage_before_the_frames_that_are_asked_for_counts(broken: Path) -> None:
    with Video.open(broken) as video:
        for _ in video.examine(17, 18):
            pass
        assert set(video.info.damaged) >= {17, 18}
        for _ in video.examine(22, 25):
            pass
        assert not {22, 25} & set(video.info.damaged)


def test_a_damaged_frame_has_a_picture_but_not_for_tracking(broken: Path) -> None:
    with Video.open(broken) as video:
        shown = [number for number, picture in video.frames(10, 24) if picture is not None]
        sound = [number for number, p in video.sound_frames(10, 24) if p is not None]
    assert sound == [10, 11, 12, 20, 21, 22, 23]
    assert set(shown) > set(sound)


def test_a_damaged_frame_decides_nothing_in_tracking(broken: Path) -> None:
    camera = Camera(width=WIDTH, height=HEIGHT, fx=400, fy=400, cx=175.5, cy=95.5)
    with Video.open(broken) as video:
        clip = ClipLoader(video, camera, WorkingSize(0)).load(11, 21)
    assert clip.damaged == set(range(13, 20))
    for level in clip.levels:
        ignored = [bool((picture[..., 3] == IGNORED).all()) for picture in level]
        assert ignored == [False] * 2 + [True] * 7 + [False] * 2


def test_frames_are_examined_once(broken: Path) -> None:
    with Video.open(broken) as video:
        examined(video)
        broken.unlink()  # nothing can be decoded any more
        assert list(video.examine(0, 29)) == []
        assert video.info.damaged == tuple(range(13, 20))


def test_examining_changes_no_frame_and_no_number(tmp_path: Path) -> None:
    path = write_numbered(tmp_path / "clip.mp4", 30, options={"g": "7", "bf": "2"})
    with Video.open(path, cache_bytes=0) as video:
        before = {n: p.tobytes() for n, p in video.frames(0, 30) if p is not None}
        examined(video)
        after = {n: p.tobytes() for n, p in video.sound_frames(0, 30) if p is not None}
    assert before == after
    assert len(after) == 30


def test_a_closed_video_is_examined_no_further(broken: Path) -> None:
    video = Video.open(broken)
    examining = video.examine(0, 29)
    next(examining)
    video.close()
    with pytest.raises(VideoError, match="closed"):
        next(examining)


def test_an_image_that_cannot_be_read_is_found_by_examining_the_folder(tmp_path: Path) -> None:
    for number in range(4):
        write_image(tmp_path / f"{number}.png", numbered_picture(number))
    (tmp_path / "2.png").write_bytes(b"no picture")
    with Video.open(tmp_path) as video:
        assert examined(video) == {2}
