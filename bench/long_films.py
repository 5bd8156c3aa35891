"""Films that are long or large, made once and kept: an hour, and one of 3840 × 2160 pixels."""

from __future__ import annotations

import io
from collections.abc import Iterator
from fractions import Fraction
from itertools import count
from pathlib import Path

import av
import cv2
import numpy as np

from bench.keeping import digest, place_for
from bench.stand import FPS
from keypose.tracker.geometry.rotations import Array

GROUP = 250
"""Frames from one key frame to the next, as x264 has them where nothing is said."""
HOUR = 3600 * FPS
HOUR_SIZE = (640, 360)
LARGE = 240
LARGE_SIZE = (3840, 2160)
LARGE_GROUP = 30
"""A second from one key frame to the next, as cameras have them."""
GRAIN = 3.0
"""Grey levels by which a pixel differs from frame to frame."""


def hour() -> Path:
    """An hour, its pictures those of the same few seconds again and again."""
    return _kept("hour of film", HOUR_SIZE, GROUP, HOUR)


def large() -> Path:
    """Some seconds of a large film."""
    return _kept("large film", LARGE_SIZE, LARGE_GROUP, LARGE)


def _kept(name: str, size: tuple[int, int], group: int, frames: int) -> Path:
    place = place_for(name, digest(Path(__file__), repr((size, group, frames)).encode()), ".mp4")
    if not place.is_file():
        half = place.with_suffix(".half.mp4")
        _repeat(_group(size, group), half, frames)
        half.rename(place)
    return place


def _group(size: tuple[int, int], frames: int) -> bytes:
    """One closed group of pictures: a pattern with some grain that moves."""
    written = io.BytesIO()
    with av.open(written, "w", format="mp4") as file:
        stream = file.add_stream("libx264", rate=Fraction(FPS))
        stream.width, stream.height, stream.pix_fmt = *size, "yuv420p"
        stream.options = {"preset": "veryfast", "g": str(frames), "bf": "0", "sc_threshold": "0"}
        for picture in _moving(size, frames):
            file.mux(stream.encode(av.VideoFrame.from_ndarray(picture, "rgb24")))
        file.mux(stream.encode())
    return written.getvalue()


def _moving(size: tuple[int, int], frames: int) -> Iterator[Array]:
    width, height = size
    random, room = np.random.default_rng(1), 64
    noise = random.normal(size=(height + 2 * room, width + 2 * room, 3)).astype(np.float32)
    pattern = cv2.GaussianBlur(noise, (0, 0), 6)
    pattern = 128 + 45 * pattern / pattern.std()
    grain = random.normal(0, GRAIN, (height, width, 1)).astype(np.float32)
    for frame in range(frames):
        turn = 2 * np.pi * frame / frames
        x, y = room + round(room * np.sin(turn)), room + round(room * np.cos(turn) / 2)
        picture = pattern[y : y + height, x : x + width] + np.roll(grain, 37 * frame, axis=1)
        yield picture.clip(0, 255).astype(np.uint8)


def _repeat(group: bytes, place: Path, frames: int) -> None:
    """A film of so many frames, a group of pictures repeated."""
    with av.open(str(place), "w") as file:
        stream, at = None, 0
        for _ in count():
            with av.open(io.BytesIO(group)) as source:
                given = source.streams.video[0]
                stream = stream or file.add_stream_from_template(given)
                for packet in source.demux(given):
                    if at == frames:
                        return
                    if packet.size:
                        packet.pts = packet.dts = round(at / FPS / packet.time_base)
                        packet.stream = stream
                        file.mux(packet)
                        at += 1
