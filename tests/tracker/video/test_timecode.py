"""The timecode that a file tells, and those of its frames."""

from __future__ import annotations

from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from keypose.tracker.video import Video
from keypose.tracker.video.info import Timecode, timecode_in


def code(text: str, fps: float) -> Timecode:
    found = Timecode.read(text, fps)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("start", "fps", "frame", "expected"),
    [
        ("00:00:00:00", 25, 0, "00:00:00:00"),
        ("01:02:03:24", 25, 1, "01:02:04:00"),
        ("10:59:59:23", 24000 / 1001, 1, "11:00:00:00"),
        ("23:59:59:24", 25, 1, "00:00:00:00"),
        ("00:00:00:00", 120, 119, "00:00:00:119"),
        ("00:00:59;29", 30000 / 1001, 1, "00:01:00;02"),
        ("00:09:59;29", 30000 / 1001, 1, "00:10:00;00"),
        ("00:00:00;00", 30000 / 1001, 17982, "00:10:00;00"),
        ("01:00:00;00", 30000 / 1001, 1800, "01:01:00;02"),
        ("00:00:59;59", 60000 / 1001, 1, "00:01:00;04"),
        ("23:59:59;29", 30000 / 1001, 1, "00:00:00;00"),
    ],
)
def test_a_frame_has_the_timecode_that_the_shoot_gave_it(
    start: str, fps: float, frame: int, expected: str
) -> None:
    assert code(start, fps).at(frame) == expected


@pytest.mark.parametrize("fps", [30000 / 1001, 60000 / 1001])
def test_dropped_numbers_are_never_shown_and_all_others_once(fps: float) -> None:
    start, minutes = code("00:00:00;00", fps), 21
    shown = [start.at(frame) for frame in range(round(fps * 60 * minutes))]
    assert len(set(shown)) == len(shown)
    assert shown == sorted(shown)
    assert not {f"00:{m:02}:00;00" for m in range(minutes) if m % 10} & set(shown)
    for frame in (0, 1799, 1800, 17981, 17982, 30000):
        assert code(shown[frame], fps).number == frame


@pytest.mark.parametrize("text", ["", "1:2:3:4", "24:00:00:00", "00:61:00:00", "00:00:00:25", "x"])
def test_what_is_no_timecode_is_none(text: str) -> None:
    assert Timecode.read(text, 25) is None
    assert timecode_in([{"title": "walk"}, {"timecode": text}], 25) is None


def test_a_files_timecode_is_read(tmp_path: Path) -> None:
    path = tmp_path / "shot.mov"
    with av.open(str(path), "w") as container:
        stream = container.add_stream("mpeg4", rate=25, options={})
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p"
        stream.metadata["timecode"] = "10:20:30:05"
        for shade in range(5):
            picture = np.full((48, 64, 3), 40 * shade, dtype=np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode(None))
    with Video.open(path) as video:
        assert str(video.info.timecode) == "10:20:30:05"


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (("shot_v2.1001.png", "shot_v2.1002.png", "shot_v2.1003.png"), "00:00:33:11"),
        (("a_9.png", "a_10.png", "a_11.png"), "00:00:00:09"),
        (("a_1.png", "a_2.png", "a_4.png"), None),
        (("a.png", "b.png", "c.png"), None),
        (("20240131.png", "20240132.png"), None),  # such days are no frames
        (("a_7.png",), None),
    ],
)
def test_images_that_are_numbered_consecutively_have_the_timecode_of_their_numbers(
    tmp_path: Path, names: tuple[str, ...], expected: str | None
) -> None:
    for name in names:
        cv2.imwrite(str(tmp_path / name), np.zeros((16, 24, 3), np.uint8))
    with Video.open(tmp_path) as video:
        code = video.info.timecode
    assert (None if code is None else str(code)) == expected
    assert code is None or code.of_files


def test_a_file_without_one_has_none() -> None:
    sample = Path(__file__).parents[3] / "sample_videos" / "person" / "person.mp4"
    with Video.open(sample) as video:
        assert video.info.timecode is None
