"""From a video to prepared clips: decoded, rectified, masked, at the size the tracker works on."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, field
from threading import RLock
from typing import Any
from weakref import WeakValueDictionary

import cv2
import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import SessionError, VideoError
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.steady import SteadyCamera
from keypose.tracker.limits import give_back
from keypose.tracker.session.settings import IgnoreMask
from keypose.tracker.video import Video
from keypose.tracker.video.panorama import Panorama, Shown, exposure_of, panorama_of, sampled
from keypose.tracker.video.pyramid import (
    ALIGNED,
    IGNORED,
    TARGET_ONLY,
    USABLE,
    Buffers,
    Clip,
    FloatPicture,
    Overview,
    Picture,
    Prepared,
    Usable,
    Window,
    level_sizes,
    prepare_into,
)
from keypose.tracker.video.still_camera import background, moving, smooth

PROCESS_BYTES = 300_000_000
"""Of a process that tracks, what libraries, compiled loops and the decoder take."""
LEAST_WINDOW = 32
"""Pixels: where a body is hardly in the picture, its window is widened by so much at once."""
WORKING_PIXELS = 640 * 960
"""Larger pictures are worked on at half size: nothing is gained above it."""
PIXEL_BYTES = 22
"""Four numbers of 16 bits at every level, and as many again while a window is widened."""
LONGEST_SEGMENT = 2000
"""Most frames between two keyframes that can be tracked."""
FAR_OUT = 1e6
"""Pixels beyond which a polygon's corner lies anyway outside every picture."""
COVERED = 250
"""Of 255 (`_film_coverage`): the least that counts as inside the film's picture."""
PLATE_FRAMES = 41
"""Frames of which a static camera's empty scene is the median."""
PANORAMA_FRAMES = 81
"""Of a camera that turns: each place is seen in some of them only."""


@dataclass(frozen=True)
class Memory:
    """Bytes that a process which tracks may take; the clip of one segment always may.

    kept: what earlier clips may go on holding where there is room beside a new one.
    """

    most: int = 1_500_000_000
    kept: int = 150_000_000


AGAIN = Memory()
"""Where segments are tracked again after an edit."""
ONCE = Memory(kept=0)
"""Where every segment is tracked once."""


def require_short(first: int, last: int) -> None:
    """SessionError where a segment is longer than can be tracked."""
    if last - first > LONGEST_SEGMENT:
        raise SessionError(
            f"Keyframes {first} and {last} lie {last - first} frames apart; "
            f"at most {LONGEST_SEGMENT} can be tracked: add a keyframe between them."
        )


@dataclass(frozen=True)
class WorkingSize:
    """Pictures halved `halvings` times; pixel centres stay at integers as in cv2.pyrDown."""

    halvings: int

    @classmethod
    def for_camera(cls, camera: Camera, longest: int, memory: Memory = AGAIN) -> WorkingSize:
        """The size at which the longest segment (frames) fits the memory."""
        halvings, pixels = 0, float(camera.width * camera.height)
        while pixels > WORKING_PIXELS or pixels * PIXEL_BYTES * longest > memory.most:
            halvings, pixels = halvings + 1, pixels / 4
        return cls(halvings)

    def camera(self, camera: Camera) -> Camera:
        """The undistorted camera of the working pictures."""
        s = 0.5**self.halvings
        (height, width) = level_sizes(camera.width, camera.height, self.halvings + 1)[-1]
        scaled = {
            "fx": camera.fx * s,
            "fy": camera.fy * s,
            "cx": camera.cx * s,
            "cy": camera.cy * s,
        }
        return camera.without_distortion().model_copy(
            update={**scaled, "width": width, "height": height}
        )

    def picture(self, image: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """A picture at the working size."""
        for _ in range(self.halvings):
            image = np.asarray(cv2.pyrDown(image), dtype=np.uint8)
        return image


@dataclass(eq=False)
class ClipLoader:
    """Prepares clips of one video: one that is in use is shared, and the most recent stay ready.

    A frame that is missing or damaged is shown as ignored everywhere: it decides nothing.

    steady: the camera in whose place pictures are shown, of one that moves.  turns (F, 3, 3): how
    that is turned from the world at every frame, where pictures are compared with the empty scene
    all around.
    """

    video: Video
    camera: Camera
    size: WorkingSize
    masks: Sequence[IgnoreMask] = ()
    static_camera: bool = False
    memory: Memory = AGAIN
    steady: SteadyCamera | None = None
    turns: Array | None = None
    _ready: WeakValueDictionary[tuple[int, int], Clip] = field(default_factory=WeakValueDictionary)
    _kept: OrderedDict[tuple[int, int], Clip] = field(default_factory=OrderedDict)
    _damaged: set[int] = field(default_factory=set)
    _plate: FloatPicture | None = None
    _around: Panorama | None = None
    _beyond: Usable | None = None
    _buffers: Buffers = field(default_factory=Buffers)
    _lock: Any = field(default_factory=RLock)

    def load(
        self, first: int, last: int, needed: Window | None = None, wanted: Window | None = None
    ) -> Clip:
        """A clip that holds the frames first … last, both included, and maybe others.

        needed: the window of the working pictures that it shows at least; it can show more later
        (`Clip.cover`); None for all of them.  wanted: the larger window to prepare where anything
        has to be prepared.
        """
        require_short(first, last)
        with self._lock:
            clip = self._covering(first, last)
            if clip is None:
                clip = self._prepare_clip(first, last, self._fitted(wanted or needed))
                self._forget_within(first, last)
                self._ready[first, last] = clip
            self._keep(clip)
            clip.cover(needed, wanted)
            return clip

    def _fitted(self, window: Window | None) -> Window:
        """The part of a window that lies within the working pictures, a little wider."""
        working = self.size.camera(self.camera)
        whole = Window.whole(working.width, working.height)
        if window is None:
            return whole
        fitted = window.within(whole)
        if min(fitted.right - fitted.left, fitted.bottom - fitted.top) < LEAST_WINDOW:
            fitted = fitted.grown(LEAST_WINDOW)
        return fitted.aligned(ALIGNED).within(whole)

    def _covering(self, first: int, last: int) -> Clip | None:
        """A ready clip that holds these frames."""
        # by items, each of which holds its clip: a segment of another thread may end meanwhile
        ready = dict(self._ready.items())
        around = (clip for span, clip in ready.items() if span[0] <= first and last <= span[1])
        return ready.get((first, last)) or next(around, None)

    def _keep(self, clip: Clip) -> None:
        """Keep a clip, as the one used last."""
        span = clip.first_frame, clip.first_frame + len(clip) - 1
        self._kept[span] = clip
        self._kept.move_to_end(span)

    def _forget_within(self, first: int, last: int) -> None:
        """Drop clips all of whose frames a new one holds."""
        for span in [s for s in self._ready if first <= s[0] and s[1] <= last]:
            self._kept.pop(span, None)
            self._ready.pop(span, None)

    def _make_room(self, needed: int, keep: Clip | None = None) -> None:
        """Drop the least recently used clips until they fit beside new pictures of so many bytes.

        keep: a clip that stays, whose pictures those are.
        """
        room = min(self.memory.kept, self.memory.most - PROCESS_BYTES - needed)
        others = [span for span, clip in self._kept.items() if clip is not keep]
        while others and sum(_size(self._kept[span].levels) for span in others) > room:
            del self._kept[others.pop(0)]
        give_back()

    def _prepare_clip(self, first: int, last: int, window: Window) -> Clip:
        """A clip in which frames that are ready are not prepared again. They are taken over before
        room is made: to go back to them, a decoder would have to begin long before."""
        made = _ClipBuffers.of(first, last, window, self._fitted(None))
        taken = {frame for frame in range(first, last + 1) if self._take_over(frame, made)}
        self._make_room(_size(made.levels))
        self._fill(made, taken)
        damaged = frozenset(n for n in self._damaged if first <= n <= last)
        whole = self._fitted(None)
        return Clip(first, made.levels, damaged, made.overview, window, whole, self._widened)

    def _widened(self, clip: Clip, window: Window) -> Prepared:
        """A clip's pictures in the smallest window that holds this one and what it shows now."""
        with self._lock:
            shown = clip.shown
            if shown.window is None or shown.holds(window):
                return shown  # by another thread, meanwhile
            wanted = self._fitted(window.joined(shown.window))
            first = clip.first_frame
            made = _ClipBuffers.of(first, first + len(clip) - 1, wanted, self._fitted(None))
            self._make_room(_size(made.levels), keep=clip)
            self._fill(made, ())
            prepared = Prepared(made.levels, wanted)
            clip.show(prepared)
            return prepared

    def _take_over(self, frame: int, made: _ClipBuffers) -> bool:
        """Copy a frame's pictures, where a ready clip shows as much of it; whether one does."""
        for clip in list(self._ready.values()):
            if 0 <= frame - clip.first_frame < len(clip) and clip.shown.holds(made.window):
                made.take(frame, clip)
                return True
        return False

    def _fill(self, made: _ClipBuffers, taken: Collection[int]) -> None:
        """Prepare all other frames."""
        for frame, grey, usable in self._missing(made.first, made.last, taken):
            made.put(frame, grey, usable, self._buffers)

    def _missing(
        self, first: int, last: int, taken: Collection[int]
    ) -> Iterator[tuple[int, NDArray[np.uint8], Usable | None]]:
        """Every other frame in grey, and what its pixels may be used for."""
        for start, stop in _gaps(first, last + 1, taken):
            reached = start
            for index, rgb in self.video.sound_frames(start, stop):
                if rgb is None:
                    self._damaged.add(index)
                yield index, *self._prepare(index, rgb)
                reached = index + 1
            if reached != stop:
                raise VideoError(
                    f"The video has no frame {last}: it holds fewer frames than it says; "
                    "convert it, and make the session anew."
                )

    def _prepare(
        self, index: int, rgb: NDArray[np.uint8] | None
    ) -> tuple[NDArray[np.uint8], Usable | None]:
        if rgb is None:
            working = self.size.camera(self.camera)
            grey = np.zeros((working.height, working.width), np.uint8)
            return grey, np.full(grey.shape, IGNORED, np.uint8)
        grey = self._grey(rgb, index)
        return grey, self._usable(index, grey)

    def _grey(self, rgb: NDArray[np.uint8], frame: int) -> NDArray[np.uint8]:
        grey = np.asarray(cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY), dtype=np.uint8)
        return self.working(grey, frame)

    def working(self, picture: NDArray[np.uint8], frame: int) -> NDArray[np.uint8]:
        """A picture of a frame without distortion, from a steady camera, at the working size."""
        picture = self.camera.rectify(picture)
        if self.steady is not None:
            picture = self.steady.picture(picture, frame)
        return self.size.picture(picture)

    def _usable(self, index: int, grey: NDArray[np.uint8]) -> Usable | None:
        """What each pixel may be used for, or None where everything may."""
        masks = [m for m in self.masks if m.first_frame <= index <= m.last_frame]
        beyond = self.steady is not None and not self.steady.covers(index)
        plate = self.static_camera or self.turns is not None
        if not (masks or plate or self.camera.is_distorted or beyond):
            return None
        if not (masks or plate or beyond):
            return self._beyond_lens(index)
        usable = np.full(grey.shape, USABLE, np.uint8)
        if plate:
            usable[self._is_background(grey, index)] = TARGET_ONLY
        if masks:
            usable[self._masked(masks, index)] = IGNORED
        if beyond:
            usable[self._film_coverage(index) < COVERED] = IGNORED
        elif self.camera.is_distorted:
            usable[self._beyond_lens(index) == IGNORED] = IGNORED
        return usable

    def _film_coverage(self, frame: int) -> NDArray[np.uint8]:
        """255 where the film has a picture of a frame, 0 beyond it, between at its edge."""
        white = np.full((self.camera.height, self.camera.width), 255, np.uint8)
        return self.working(white, frame)

    def _beyond_lens(self, frame: int) -> Usable:
        """The rectified picture's pixels, but for those that the lens never showed."""
        if self._beyond is None:
            is_covered = self._film_coverage(frame) >= COVERED
            self._beyond = np.where(is_covered, np.uint8(USABLE), np.uint8(IGNORED))
        return self._beyond

    def _masked(self, masks: Sequence[IgnoreMask], frame: int) -> NDArray[np.bool_]:
        drawn = np.zeros((self.camera.height, self.camera.width), np.uint8)
        for mask in masks:
            corners = np.clip(np.array(mask.polygon), -FAR_OUT, FAR_OUT)
            cv2.fillPoly(drawn, [np.round(corners).astype(np.int32)], 255)
        return self.working(drawn, frame) > 0

    def _is_background(self, grey: NDArray[np.uint8], frame: int) -> NDArray[np.bool_]:
        """Pixels that look as the empty scene does: no part of a moving body."""
        if self.turns is not None:
            plate, is_known = self.panorama().seen(self.turns[frame])
            bright = plate * np.float32(exposure_of(grey, plate, is_known))
            return is_known & ~moving(smooth(grey), smooth(bright))
        if self._plate is None:
            self._plate = self._median_picture()
        return ~moving(smooth(grey), self._plate)

    def panorama(self) -> Panorama:
        """The background all around a camera that turns, in grey."""
        if self._around is None:
            self._around = self._put_together(self._grey, PANORAMA_FRAMES)
        return self._around

    def panorama_in_colour(self) -> Panorama:
        """The same in RGB, of half as many frames; it is not kept."""
        return self._put_together(self.working, PANORAMA_FRAMES // 2)

    def _put_together(
        self, prepared: Callable[[NDArray[np.uint8], int], NDArray[np.uint8]], most: int
    ) -> Panorama:
        """The background of `most` frames at most, each prepared from its RGB picture."""
        assert self.turns is not None
        pictures = []
        for frame in sampled(self.turns, most):
            for _, rgb in self.video.frames(frame, frame + 1):
                if rgb is not None:
                    is_covered = self._film_coverage(frame) > COVERED
                    pictures.append(Shown(prepared(rgb, frame), is_covered, self.turns[frame]))
        return panorama_of(self.size.camera(self.camera), pictures)

    def _median_picture(self) -> FloatPicture:
        """The static background: every pixel's median over frames spread over the video."""
        count = self.video.info.frame_count
        frames = np.unique(np.linspace(0, count - 1, PLATE_FRAMES).round().astype(int))
        pictures = [
            self._grey(rgb, int(frame))
            for frame in frames
            for _, rgb in self.video.frames(int(frame), int(frame) + 1)  # a median tolerates damage
            if rgb is not None
        ]
        return smooth(background(pictures))


@dataclass(frozen=True, eq=False)
class _ClipBuffers:
    """Arrays of a clip of the frames first … last that are being filled."""

    first: int
    last: int
    window: Window
    levels: tuple[Picture, ...]
    overview: Overview

    @classmethod
    def of(cls, first: int, last: int, window: Window, whole: Window) -> _ClipBuffers:
        """Room for all frames."""
        count = last - first + 1
        levels = tuple(np.empty((count, h, w, 4), np.int16) for h, w in window.sizes)
        return cls(first, last, window, levels, Overview.empty(count, whole))

    def put(
        self, frame: int, grey: NDArray[np.uint8], usable: Usable | None, buffers: Buffers
    ) -> None:
        """Prepare a frame's pictures."""
        index = frame - self.first
        pictures = [level[index] for level in self.levels]
        prepare_into(pictures, grey, usable, self.window, buffers)
        self.overview.put(index, grey, usable)

    def take(self, frame: int, clip: Clip) -> None:
        """Copy a frame's pictures from a clip that shows as much of it."""
        index, slot = frame - self.first, frame - clip.first_frame
        for k, level in enumerate(self.levels):
            level[index] = clip.shown.cut(slot, k, self.window.halved(k))
        self.overview.grey[index] = clip.overview.grey[slot]
        self.overview.use[index] = clip.overview.use[slot]


def _size(levels: Sequence[Picture]) -> int:
    """Bytes."""
    return sum(level.nbytes for level in levels)


def _gaps(start: int, stop: int, ready: Collection[int]) -> list[tuple[int, int]]:
    """The runs of frames, start to before stop, that are not ready."""
    wanted = {frame for frame in range(start, stop) if frame not in ready}
    starts = [frame for frame in sorted(wanted) if frame - 1 not in wanted]
    stops = [frame + 1 for frame in sorted(wanted) if frame + 1 not in wanted]
    return list(zip(starts, stops, strict=True))
