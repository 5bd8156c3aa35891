"""Small films of many kinds, and mutants of them: one bit or one word of a packet changed."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import av
import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.video import Video
from tests.tracker.video_cases import Picture, write_clip

WIDTH = 352
HEIGHT = 192
COUNT = 32
SEEN = 3.0
"""Grey levels, in the mean over the picture, from which on a frame is seen to be wrong."""
TS_PACKET = 188
TS_HEAD = 34


@dataclass(frozen=True)
class FilmKind:
    """How a film is coded."""

    name: str
    codec: str = "libx264"
    options: dict[str, str] = field(default_factory=dict)
    pixels: str = "yuv420p"


def _x264(**settings: str) -> dict[str, str]:
    return {"x264-params": ":".join(f"{name}={value}" for name, value in settings.items())}


FILMS = (
    FilmKind("cabac.mp4", options=_x264(keyint="12", bframes="0")),
    FilmKind("cavlc.mp4", options=_x264(keyint="12", bframes="0", cabac="0")),
    FilmKind("b_frames.mkv", options=_x264(keyint="16", bframes="3", **{"b-adapt": "0"})),
    FilmKind(
        "open_gop.mp4",
        options=_x264(keyint="12", bframes="3", scenecut="0", **{"b-adapt": "0", "open-gop": "1"}),
    ),
    FilmKind("slices.ts", options=_x264(keyint="12", slices="3")),
    FilmKind("hevc.mp4", "libx265", {"x265-params": "keyint=12:log-level=none:pools=1"}),
    FilmKind("mpeg4.avi", "mpeg4", {"g": "12", "bf": "2", "b": "800k"}),
    FilmKind("mpeg2.mkv", "mpeg2video", {"g": "12", "bf": "2", "b": "800k"}),
    FilmKind("vp9.webm", "libvpx-vp9", {"g": "12", "cpu-used": "8", "b": "400k"}),
    FilmKind("av1.mp4", "libsvtav1", {"g": "12", "preset": "12"}),
)


def moving_pictures(width: int, height: int, count: int = COUNT) -> list[Picture]:
    """A textured square that goes its own way before a panned, softer ground."""
    noise = np.random.default_rng(1)
    ground = _soft(noise.integers(0, 256, (height, width + count, 3)), 3.0)
    square = _soft(noise.integers(0, 256, (32, 32, 3)), 1.2)
    pictures = []
    for number in range(count):
        picture = ground[:, number : number + width].copy()
        x = round(64 + 50 * np.sin(number / 8))
        y = round(32 + 28 * np.cos(number / 11))
        picture[y : y + 32, x : x + 32] = square
        pictures.append(picture)
    return pictures


def _soft(noise: NDArray[np.int64], sigma: float) -> Picture:
    soft = np.asarray(cv2.GaussianBlur(noise.astype(np.float32), (0, 0), sigma))
    return np.asarray(255 * (soft - soft.min()) / np.ptp(soft), dtype=np.uint8)


def _black_bars(pictures: list[Picture], across: bool) -> list[Picture]:
    """Bars of a sixth at both ends: above and below, or at both sides."""
    width, height = pictures[0].shape[1] // 6, pictures[0].shape[0] // 6
    shown = np.zeros_like(pictures[0])
    inner = np.s_[height:-height] if across else np.s_[:, width:-width]
    shown[inner] = 1
    return [picture * shown for picture in pictures]


def _begun_with(pictures: list[Picture], first: Picture, count: int) -> list[Picture]:
    return [first] * count + pictures[count:]


def _title(like: Picture) -> Picture:
    card = np.zeros_like(like)
    cv2.putText(card, "A WALK", (80, 100), cv2.FONT_HERSHEY_SIMPLEX, 1.0, (255, 255, 255), 2)
    return card


FLAT: dict[str, Callable[[list[Picture]], list[Picture]]] = {
    "black at first": lambda p: _begun_with(p, np.zeros_like(p[0]), 5),
    "a title card": lambda p: _begun_with(p, _title(p[0]), 12),
    "a fade-in": lambda p: [(one * min(1, k / 15)).astype(np.uint8) for k, one in enumerate(p)],
    "a white flash": lambda p: [*p[:12], *[np.full_like(p[0], 255)] * 2, *p[14:]],
    "flat grey": lambda p: [*p[:8], *[np.full_like(p[0], 128)] * 12, *p[20:]],
    "nothing but red": lambda p: [np.zeros_like(p[0]) + np.uint8([200, 30, 30])] * len(p),
    "bars above and below": lambda p: _black_bars(p, across=True),
    "bars at the sides": lambda p: _black_bars(p, across=False),
    "night": lambda p: [one // 16 for one in p],
}
"""What films show of which some pictures, or parts of them, show nothing."""


def write_film(
    folder: Path,
    kind: FilmKind,
    width: int = WIDTH,
    height: int = HEIGHT,
    shown: Callable[[list[Picture]], list[Picture]] = lambda pictures: pictures,
) -> Path:
    """A film of that kind; shown: what it shows of the usual pictures."""
    pictures = shown(moving_pictures(width, height))
    options = {"threads": "1", **kind.options}  # the same film on every computer
    path = folder / kind.name
    return write_clip(path, pictures, codec=kind.codec, pixels=kind.pixels, options=options)


def mutants(film: Path, count: int) -> Iterator[Path]:
    """Copies of a film, every other one with one bit turned, the rest with four bytes replaced."""
    places, content = _payload(film), film.read_bytes()
    for seed in range(count):
        chance = random.Random(f"{film.name} {seed}")
        place, mutant = chance.choice(places), bytearray(content)
        if seed % 2:
            mutant[place : place + 4] = chance.randbytes(len(mutant[place : place + 4]))
        else:
            mutant[place] ^= 1 << chance.randrange(8)
        path = film.with_name(f"{seed}-{film.name}")
        path.write_bytes(mutant)
        yield path
        path.unlink()


def _payload(film: Path) -> list[int]:
    """Where in the file pictures lie, byte by byte."""
    content = film.read_bytes()
    if film.suffix == ".ts":
        starts = range(5 * TS_PACKET, len(content), TS_PACKET)
        return [start + k for start in starts for k in range(TS_HEAD, TS_PACKET)]
    places: list[int] = []
    with av.open(str(film)) as container:
        for packet in container.demux(video=0):
            if packet.size:
                start = content.index(bytes(packet))
                places.extend(range(start, start + packet.size))
    return places


@dataclass
class Tally:
    """Of frames that are wrong, how many there are and how many are known to be damaged."""

    wrong: int = 0
    known: int = 0

    def add(self, mutant: Path, sound: dict[int, NDArray[np.uint8]]) -> None:
        """Count the frames of a mutant; `sound` are those of the film by their pts."""
        with Video.open(mutant) as video:
            damaged = examined(video)
            for number, picture in video.frames(0, video.info.frame_count):
                before = sound.get(int(video.info.pts[number]))
                if picture is None or before is None or before.shape != grey(picture).shape:
                    continue
                if cv2.absdiff(before, grey(picture)).mean() > SEEN:
                    self.wrong += 1
                    self.known += number in damaged


def examined(video: Video) -> set[int]:
    """The frames that are damaged or missing, once all are examined."""
    for _ in video.examine(0, video.info.frame_count - 1):
        pass
    return {*video.info.damaged, *video.info.missing}


def greys(film: Path) -> dict[int, NDArray[np.uint8]]:
    """The frames of a film by their pts."""
    with Video.open(film) as video:
        pictures = video.frames(0, video.info.frame_count)
        return {int(video.info.pts[n]): grey(p) for n, p in pictures if p is not None}


def grey(picture: Picture) -> NDArray[np.uint8]:
    return np.asarray(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY), dtype=np.uint8)
