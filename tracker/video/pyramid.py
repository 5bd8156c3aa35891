"""Pictures made ready for the loops: brightness, its gradient, and what may be used, by level.

All three in whole steps of 1/128 of a grey level, or of what is wholly usable.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.kernels.layout import STEPS

if TYPE_CHECKING:
    from keypose.tracker.kernels.layout import Lens

LEVELS = 3
BLUR_PX = 0.8
USABLE = STEPS
TARGET_ONLY = STEPS // 2
IGNORED = 0

Picture = NDArray[np.int16]
Usable = NDArray[np.uint8]
"""What each pixel may be used for."""
FloatPicture = NDArray[np.float32]
"""A picture, or brightness alone, in grey levels."""


class Window(NamedTuple):
    """A rectangle of a picture: the pixels left … right − 1 and top … bottom − 1."""

    left: int
    top: int
    right: int
    bottom: int

    @classmethod
    def whole(cls, width: int, height: int) -> Window:
        """All of a picture."""
        return cls(0, 0, width, height)

    @property
    def is_empty(self) -> bool:
        """Whether it has no pixel."""
        return self.left >= self.right or self.top >= self.bottom

    @property
    def sizes(self) -> list[tuple[int, int]]:
        """(height, width) of its every level."""
        return level_sizes(self.right - self.left, self.bottom - self.top, LEVELS)

    def holds(self, other: Window) -> bool:
        """Whether all of another one lies within it."""
        return self.joined(other) == self

    def joined(self, other: Window) -> Window:
        """The smallest one that holds both."""
        return Window(
            min(self.left, other.left),
            min(self.top, other.top),
            max(self.right, other.right),
            max(self.bottom, other.bottom),
        )

    def within(self, other: Window) -> Window:
        """The part of it within another one; empty ones lie at a corner of that."""
        left, right = (min(max(x, other.left), other.right) for x in (self.left, self.right))
        top, bottom = (min(max(y, other.top), other.bottom) for y in (self.top, self.bottom))
        return Window(left, top, right, bottom)

    def seen_from(self, other: Window) -> Window:
        """It counted from the upper left pixel of another one."""
        left, top = other.left, other.top
        return Window(self.left - left, self.top - top, self.right - left, self.bottom - top)

    def grown(self, pixels: float) -> Window:
        """It with so many more pixels on every side."""
        by = int(np.ceil(pixels))
        return Window(self.left - by, self.top - by, self.right + by, self.bottom + by)

    def aligned(self, step: int) -> Window:
        """The smallest one around it that begins and ends at multiples of a step."""
        return Window(
            self.left // step * step,
            self.top // step * step,
            -(-self.right // step) * step,
            -(-self.bottom // step) * step,
        )

    def halved(self, times: int) -> Window:
        """The smallest one around it in pictures that are halved so many times."""
        scale = 2**times
        return Window(
            self.left // scale, self.top // scale, -(-self.right // scale), -(-self.bottom // scale)
        )

    def doubled(self, times: int) -> Window:
        """It in pictures that are doubled so many times."""
        scale = 2**times
        return Window(*(scale * x for x in self))

    def of(self, picture: NDArray[Any]) -> NDArray[Any]:
        """It cut out of a picture (h, w, …), as a view."""
        return picture[self.top : self.bottom, self.left : self.right]


def level_sizes(width: int, height: int, levels: int) -> list[tuple[int, int]]:
    """(height, width) of every level, as cv2.pyrDown makes them."""
    sizes = [(height, width)]
    for _ in range(levels - 1):
        h, w = sizes[-1]
        sizes.append(((h + 1) // 2, (w + 1) // 2))
    return sizes


ALIGNED = 2 ** (LEVELS - 1)
"""Pixels to whose multiples windows reach, so that they begin at whole pixels at every level."""
HALO = 32
"""Pixels around a window that are prepared with it: blur, halving and rims of the ignored reach 28
pixels from the coarsest level, so that a window's numbers are the whole picture's."""


class Buffers:
    """Arrays for steps on the way to a picture, kept from one to the next: memory that is fresh
    takes longer to touch than the work. For one thread at a time."""

    def __init__(self) -> None:
        self._kept: dict[str, NDArray[np.int16]] = {}
        self._uses: tuple[Usable, Window, list[NDArray[np.int16]]] | None = None

    def array(self, name: str, shape: tuple[int, ...]) -> NDArray[np.int16]:
        """The array of this name; what it holds is of before."""
        kept = self._kept.get(name)
        if kept is None or kept.shape != shape:
            kept = self._kept[name] = np.empty(shape, np.int16)
        return kept

    def uses(self, usable: Usable | None, around: Window) -> list[NDArray[np.int16]] | None:
        """What a part of a picture may be used for, at every level; None where all is. Of an array
        that is the last one's it is known."""
        if usable is None:
            return None
        if self._uses is None or self._uses[0] is not usable or self._uses[1] != around:
            use, usable_levels = _with_rim(around.of(usable)), []
            for level in range(LEVELS):
                use = _with_rim(use)[::2, ::2] if level else use
                usable_levels.append(use.astype(np.int16))
            self._uses = usable, around, usable_levels
        return self._uses[2]


def prepare(grey: NDArray[np.uint8], usable: Usable | None, levels: int) -> list[Picture]:
    """Pyramid of one picture: level k is (h / 2^k, w / 2^k, 4) int16 of [E, E_u, E_v, use].

    grey: (h, w) brightness. usable: (h, w) USABLE, TARGET_ONLY (not a source: the background) or
    IGNORED, or None where all is. E is blurred a little, the gradient is Scharr's, per pixel.
    Around what is ignored a rim is ignored too, as wide as blur and gradient reach.
    """
    height, width = grey.shape
    sizes = level_sizes(width, height, levels)
    pictures = [np.empty((*size, 4), np.int16) for size in sizes]
    prepare_into(pictures, grey, usable, Window.whole(width, height), Buffers())
    return pictures


def prepare_into(
    pictures: Sequence[Picture],
    grey: NDArray[np.uint8],
    usable: Usable | None,
    window: Window,
    buffers: Buffers,
) -> None:
    """Prepare a window of a picture, (h, w, 4) for every level, in arrays that are there."""
    height, width = grey.shape
    around = window.grown(HALO).aligned(ALIGNED).within(Window.whole(width, height))
    inside, uses = window.seen_from(around), buffers.uses(usable, around)
    sharp = buffers.array("sharp", around.of(grey).shape)
    np.multiply(around.of(grey), STEPS, out=sharp, dtype=np.int16)
    current = buffers.array("level 0", sharp.shape)
    cv2.GaussianBlur(sharp, (0, 0), BLUR_PX, dst=current)
    for level, picture in enumerate(pictures):
        if level:
            halved = buffers.array(f"level {level}", _halved(current.shape))
            current = np.asarray(cv2.pyrDown(current, dst=halved), np.int16)
        channels = [current]
        for du in (1, 0):
            slope = buffers.array(f"slope {du} {level}", current.shape)
            cv2.Scharr(current, cv2.CV_16S, du, 1 - du, scale=1 / 32.0, dst=slope)
            channels.append(slope)
        use = buffers.array(f"use {level}", current.shape)
        use[:] = USABLE if uses is None else uses[level]
        cut = inside.halved(level)
        cv2.merge([cut.of(each) for each in (*channels, use)], dst=picture)


def _halved(shape: tuple[int, ...]) -> tuple[int, ...]:
    return tuple((side + 1) // 2 for side in shape)


def in_grey_levels(picture: Picture) -> FloatPicture:
    """The same picture as single precision, brightness and gradient in grey levels; what it may be
    used for as it is."""
    return picture.astype(np.float32) * np.array([1 / STEPS] * 3 + [1], np.float32)


def _with_rim(usable: Usable) -> Usable:
    """The same with a rim of four pixels ignored as well.

    Blur, gradient and interpolation reach that far together.
    """
    ignored = (usable == IGNORED).astype(np.uint8)
    near = cv2.dilate(ignored, np.ones((9, 9), np.uint8)) > 0
    return np.where(near, np.uint8(IGNORED), usable)


class Overview(NamedTuple):
    """All of the pictures of a clip at the coarsest level, whatever its window.

    grey, use (n, h, w): brightness, and what a pixel may be used for.
    """

    grey: NDArray[Any]
    use: NDArray[Any]

    @classmethod
    def empty(cls, count: int, window: Window) -> Overview:
        """Room for the pictures of so many frames."""
        size = window.sizes[-1]
        return cls(*(np.empty((count, *size), np.uint8) for _ in range(2)))

    def put(self, index: int, grey: NDArray[np.uint8], usable: Usable | None) -> None:
        """Take one picture at its full size."""
        coarse = grey
        for _ in range(LEVELS - 1):
            coarse = np.asarray(cv2.pyrDown(coarse), np.uint8)
        step = 2 ** (LEVELS - 1)
        self.grey[index] = coarse
        self.use[index] = USABLE if usable is None else usable[::step, ::step]


class Prepared(NamedTuple):
    """What a clip shows at a time: one array (n, h, w, 4) int16 for each pyramid level, finest
    first, of a window of the picture; None for all of it."""

    levels: tuple[Picture, ...]
    window: Window | None = None

    def holds(self, wanted: Window) -> bool:
        """Whether it shows all of a window that lies within the picture."""
        return self.window is None or wanted.is_empty or self.window.holds(wanted)

    def seen_by(self, lens: Lens) -> Lens:
        """A lens of the whole picture that knows where in it the arrays begin."""
        if self.window is None:
            return lens
        return lens._replace(left=self.window.left, top=self.window.top)

    def cut(self, slot: int, level: int, wanted: Window) -> Picture:
        """A window (h, w, 4) of one picture; IndexError where it is not all shown.

        wanted: in pixels of that level.
        """
        picture: Picture = self.levels[level][slot]
        if self.window is not None:
            wanted = wanted.seen_from(self.window.halved(level))
        if not Window.whole(picture.shape[1], picture.shape[0]).holds(wanted):
            raise IndexError(f"the pictures show less than {wanted}")
        return wanted.of(picture)


class Clip:
    """Prepared pictures of consecutive frames, of the whole picture or of a window of it.

    damaged: the frames whose pictures are missing or damaged; all of them is IGNORED.
    whole: the whole picture, where there is a window.  overview: all of it, coarse; the coarsest
    level where that is left out.  widened: prepares a clip's pictures in a wider window.
    """

    def __init__(
        self,
        first_frame: int,
        levels: tuple[Picture, ...],
        damaged: frozenset[int] = frozenset(),
        overview: Overview | None = None,
        window: Window | None = None,
        whole: Window | None = None,
        widened: Callable[[Clip, Window], Prepared] | None = None,
    ) -> None:
        self.first_frame, self.damaged = first_frame, damaged
        self._shown, self._whole, self._widened = Prepared(levels, window), whole, widened
        self._overview = overview

    def __len__(self) -> int:
        return len(self.levels[0])

    @property
    def levels(self) -> tuple[Picture, ...]:
        """The arrays of what it shows now."""
        return self._shown.levels

    @property
    def shown(self) -> Prepared:
        """What it shows now; another thread may widen it meanwhile."""
        return self._shown

    def within(self, wanted: Window | None) -> Window | None:
        """The part of a window that lies within the picture; all of that for None."""
        return self._whole if wanted is None or self._whole is None else wanted.within(self._whole)

    def cover(self, needed: Window | None, wanted: Window | None = None) -> Prepared:
        """What it shows, widened, if need be, to hold a window as far as the picture reaches: its
        frames are prepared again.

        needed: None for all of the picture.  wanted: what it is widened to, so that the next step
        does not widen it once more; what is needed where that is left out.
        """
        shown, inside = self._shown, self.within(needed)
        if self._widened is None or inside is None or shown.holds(inside):
            return shown
        wider = inside if wanted is None else self.within(wanted)
        assert wider is not None
        return self._widened(self, wider.joined(inside))

    def show(self, prepared: Prepared) -> None:
        """Show these from now on: for the loader, which lets one thread widen at a time."""
        self._shown = prepared

    @property
    def overview(self) -> Overview:
        """All of the pictures, coarse."""
        if self._overview is not None:
            return self._overview
        coarsest = self.levels[-1]
        return Overview(coarsest[..., 0] / STEPS, coarsest[..., 3])

    def slots(self, first_frame: int, last_frame: int) -> NDArray[np.int64]:
        """Where the frames first_frame … last_frame lie in the arrays; IndexError beyond
        them.
        """
        if first_frame < self.first_frame or last_frame >= self.first_frame + len(self):
            raise IndexError(f"frames {first_frame} to {last_frame} are not all in the clip")
        return np.arange(first_frame - self.first_frame, last_frame - self.first_frame + 1)
