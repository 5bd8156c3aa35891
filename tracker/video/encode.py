"""Pictures into a film, every one at the time it is given: H.264 in MP4, or with alpha.

    with film_file(Path("film.mp4"), overwrite=False) as place:
        with FilmWriter(place, (640, 360), Fraction(1, 25), Fraction(25)) as film:
            for pts, picture in enumerate(pictures):  # (height, width, 3) uint8 RGB
                film.add(picture, pts)

One picture is held at a time, and the quality is even: what is hard to code gets more bytes.
"""

from __future__ import annotations

import os
import secrets
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from types import TracebackType
from typing import Final, Self

import av
from av.video.reformatter import ColorRange, Colorspace, VideoReformatter

from keypose.tracker.errors import VideoError
from keypose.tracker.video.container import PYAV_ERRORS
from keypose.tracker.video.picture import Picture

QUALITY = 18
"""Of H.264 and VP9, lower is better: drawn lines and letters stay sharp."""
LARGEST_SIDE = 8192
BT709 = 1
"""The number of that standard, for colours, their spread and their primaries."""


@dataclass(frozen=True)
class FilmFormat:
    """How a film is coded. name: of the codec, for a person; pixels: without alpha, and with it
    where that can be."""

    name: str
    container: str
    codec: str
    pixels: tuple[str, ...]
    options: Mapping[str, str]
    container_options: Mapping[str, str]


_FAST_START: Final = {"movflags": "+faststart"}
MP4: Final = FilmFormat(
    *("H.264", "mp4", "libx264", ("yuv420p",)),
    *({"crf": str(QUALITY), "preset": "veryfast"}, _FAST_START),
)
WEBM: Final = FilmFormat(
    *("VP9", "webm", "libvpx-vp9", ("yuv420p", "yuva420p")),
    *({"crf": str(QUALITY), "b": "0", "deadline": "good", "cpu-used": "4"}, {}),
)
MOV: Final = FilmFormat(
    *("ProRes", "mov", "prores_ks", ("yuv444p10le", "yuva444p10le")),
    *({"profile": "4444"}, _FAST_START),
)


def can_write_films(kind: FilmFormat = MP4) -> bool:
    """Whether the installed PyAV brings the encoder."""
    return kind.codec in av.codecs_available


class FilmWriter:
    """A film being written. Leaving its block by an error leaves the file unfinished."""

    def __init__(
        self,
        place: Path,
        size: tuple[int, int],
        time_base: Fraction,
        rate: Fraction,
        pixel_aspect: Fraction | None = None,
        kind: FilmFormat = MP4,
        *,
        alpha: bool = False,
    ) -> None:
        """Begin a film of this size, whose times count in time_base seconds; of H.264 both sides
        are even.

        rate: frames a second, on average. pixel_aspect: width over height of a pixel.
        alpha: pictures are RGBA, alpha straight.
        VideoError in one sentence when it cannot be begun.
        """
        width, height = size
        odd = kind is MP4 and (width % 2 or height % 2)
        if odd or not 2 <= min(size) <= max(size) <= LARGEST_SIDE:
            raise VideoError(
                f"A film of {width}×{height} pixels cannot be made: both sides must be "
                f"{'even' if kind is MP4 else '2 or more'}, and at most {LARGEST_SIDE}."
            )
        if not can_write_films(kind):
            raise VideoError(
                f"The installed PyAV cannot write {kind.name}: install it anew with pip install av."
            )
        self._place, self._time_base = place, time_base
        self._given, self._pixels = "rgba" if alpha else "rgb24", kind.pixels[alpha]
        self._reformatter = VideoReformatter()
        self._last: int | None = None
        with _encoder_errors(place):
            self._container = av.open(
                f"file:{place}", "w", format=kind.container, options=dict(kind.container_options)
            )
        try:
            with _encoder_errors(place):
                self._begin(size, rate, pixel_aspect, kind)
        except BaseException:
            self._container.close()
            raise

    def _begin(
        self,
        size: tuple[int, int],
        rate: Fraction,
        pixel_aspect: Fraction | None,
        kind: FilmFormat,
    ) -> None:
        stream = self._container.add_stream(kind.codec, rate=rate, options=dict(kind.options))
        assert isinstance(stream, av.VideoStream)
        stream.width, stream.height = size
        stream.pix_fmt = self._pixels
        if kind is WEBM and self._given == "rgba":
            stream.metadata["alpha_mode"] = "1"  # players look for it
        stream.time_base = self._time_base
        context = stream.codec_context
        context.time_base = self._time_base
        context.color_range = ColorRange.MPEG
        context.colorspace = Colorspace.ITU709
        context.color_primaries = context.color_trc = BT709
        if pixel_aspect is not None and pixel_aspect != 1:
            context.sample_aspect_ratio = pixel_aspect
        self._stream = stream
        self._duration = max(1, round(1 / (rate * self._time_base)))

    def add(self, picture: Picture, pts: int) -> None:
        """The next picture, shown from pts on, in units of the film's time base."""
        if self._last is not None and pts <= self._last:
            raise ValueError(f"a picture at {pts} cannot follow one at {self._last}")
        self._last = pts
        frame = self._reformatter.reformat(
            av.VideoFrame.from_ndarray(picture, format=self._given),
            format=self._pixels,
            dst_colorspace=Colorspace.ITU709,
            threads=1,
        )
        frame.pts, frame.time_base = pts, self._time_base
        with _encoder_errors(self._place):
            self._container.mux(self._packets(frame))

    def _packets(self, frame: av.VideoFrame | None) -> list[av.Packet[av.VideoStream]]:
        packets = self._stream.encode(frame)
        for packet in packets:
            packet.duration = self._duration  # which counts for the last one alone
        return packets

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if kind is not None:
            with suppress(*PYAV_ERRORS, OSError):
                self._container.close()
            return
        with _encoder_errors(self._place):
            if self._last is not None:
                self._container.mux(self._packets(None))
            self._container.close()


@contextmanager
def film_file(path: Path, *, overwrite: bool) -> Iterator[Path]:
    """A place beside the path to write to; when the block ends well, the file gets its name.

    If the block fails, nothing is left. VideoError when writing fails.
    """
    beside = path.with_name(f".{path.name}.{secrets.token_hex(6)}.part")
    try:
        beside.open("xb").close()  # whether it can be written is known before the work
        yield beside
        with beside.open("rb") as file:
            os.fsync(file.fileno())
        _publish(beside, path, overwrite)
    except OSError as problem:
        raise VideoError(
            f"{str(path)!r} cannot be written: {problem.strerror or problem}."
        ) from None
    finally:
        with suppress(OSError):
            beside.unlink()


def _publish(beside: Path, path: Path, overwrite: bool) -> None:
    if overwrite:
        beside.replace(path)
        return
    try:
        path.hardlink_to(beside)
    except FileExistsError:
        raise VideoError(f"{str(path)!r} exists already and is not overwritten.") from None
    except OSError:  # a file system without links: the look and the rename are two steps there
        if path.exists():
            raise VideoError(f"{str(path)!r} exists already and is not overwritten.") from None
        beside.rename(path)


@contextmanager
def _encoder_errors(place: Path) -> Iterator[None]:
    """Encoder errors as a VideoError in one sentence."""
    try:
        yield
    except PYAV_ERRORS as error:
        name = place.name.lstrip(".").rsplit(".", 2)[0] if place.suffix == ".part" else place.name
        reason = getattr(error, "strerror", None) or error
        raise VideoError(f'The film "{name}" cannot be written: {reason}.') from error
