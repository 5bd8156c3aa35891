"""The focal length that a file names is read; what cannot be one is not taken for it."""

from __future__ import annotations

import struct
from pathlib import Path

import av
import cv2
import numpy as np
import pytest

from keypose.tracker.video import Video
from keypose.tracker.video.info import FileLens, lens_in

QUICKTIME = "com.apple.quicktime."
FOCAL = f"{QUICKTIME}camera.focal_length.35mm_equivalent"


@pytest.mark.parametrize(
    ("tags", "lens"),
    [
        ({FOCAL: "26"}, FileLens(26.0)),
        ({FOCAL: "13.5 mm"}, FileLens(13.5)),
        (
            {FOCAL: "77", f"{QUICKTIME}make": "Apple", f"{QUICKTIME}model": "iPhone 15 Pro"},
            FileLens(77.0, "Apple iPhone 15 Pro"),
        ),
        (
            {"Make": "Google", "Model": "Pixel 7", "ExifIFD/FocalLengthIn35mmFilm": "     26"},
            FileLens(26.0, "Google Pixel 7"),
        ),
        ({"FocalLengthIn35mmFilm": "50", "Make": "NIKON", "Model": "NIKON Z 6"},
         FileLens(50.0, "NIKON Z 6")),
        ({FOCAL: "26", "model": "a\x00b\n" + 200 * "c"}, FileLens(26.0, "ab" + 58 * "c")),
    ],
    ids=str,
)  # fmt: skip
def test_the_lens_is_read_with_its_device(tags: dict[str, str], lens: FileLens) -> None:
    assert lens_in([{}, tags]) == lens


@pytest.mark.parametrize(
    "text", ["", "0", "-26", "nan", "1e9", "3.9", "2001", "26 26", "twenty", "٢٦", "inf"]
)
def test_what_no_lens_has_is_as_if_it_were_not_there(text: str) -> None:
    assert lens_in([{FOCAL: text, "make": "Apple"}]) is None


def test_a_device_alone_gives_no_lens() -> None:
    assert lens_in([{"com.android.manufacturer": "Google", "com.android.model": "Pixel 7"}]) is None


def write_film(path: Path, tags: dict[str, str]) -> Path:
    with av.open(str(path), "w", options={"movflags": "use_metadata_tags"}) as container:
        container.metadata.update(tags)
        stream = container.add_stream("h264", 30)
        stream.width, stream.height = 64, 48
        for level in (10, 90, 200):
            picture = np.full((48, 64, 3), level, np.uint8)
            container.mux(stream.encode(av.VideoFrame.from_ndarray(picture, format="rgb24")))
        container.mux(stream.encode(None))
    return path


def exif(focal_mm: int) -> bytes:
    """An EXIF block (TIFF 6.0, little-endian): the maker, and one tag of the Exif directory."""
    make = b"Google\0"
    make_at = 8 + 2 + 2 * 12 + 4
    directory = struct.pack("<H", 2)
    directory += struct.pack("<HHII", 0x010F, 2, len(make), make_at)
    directory += struct.pack("<HHII", 0x8769, 4, 1, make_at + len(make)) + struct.pack("<I", 0)
    own = struct.pack("<H", 1) + struct.pack("<HHIHH", 0xA405, 3, 1, focal_mm, 0) + b"\0\0\0\0"
    return b"Exif\0\0II*\0" + struct.pack("<I", 8) + directory + make + own


def test_films_and_images_give_their_lens(tmp_path: Path) -> None:
    film = write_film(tmp_path / "film.mov", {FOCAL: "26", f"{QUICKTIME}model": "iPhone 14"})
    with Video.open(film) as video:
        assert video.info.lens == FileLens(26.0, "iPhone 14")
    with Video.open(write_film(tmp_path / "plain.mp4", {})) as video:
        assert video.info.lens is None
    folder = tmp_path / "images"
    folder.mkdir()
    picture = cv2.imencode(".jpg", np.zeros((48, 64, 3), np.uint8))[1].tobytes()
    block = exif(35)
    marked = picture[:2] + b"\xff\xe1" + struct.pack(">H", len(block) + 2) + block + picture[2:]
    (folder / "a.jpg").write_bytes(marked)
    with Video.open(folder) as video:
        assert video.info.lens == FileLens(35.0, "Google")
