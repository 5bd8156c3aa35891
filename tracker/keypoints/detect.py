"""Detect keypoints over many frames: the network follows one body from frame to frame.

Regions are rounded: chains that come from different keyframes soon look at the same ones, and what
one of them found serves the other.

What it sees in one frame decides where to look in the next. It starts at seeds, frames where
somebody said where the body is. Between two seeds the chain forward from the first is taken, and
where that loses the body, or comes out beside the second seed's, the chain backward from the
second.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import astuple, dataclass, replace
from itertools import pairwise
from typing import Final, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import KeypointError, listed
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.blazepose import NAMES, Seen
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.layouts import AP_10K
from keypose.tracker.keypoints.person_mask import PersonMask
from keypose.tracker.keypoints.region import Box, Region

LEAST_PRESENCE: Final = 0.5
LOOK_PARTS: Final = 32
"""Regions are rounded to so many parts of their size before each look."""


@dataclass(frozen=True)
class Subject:
    """Whose keypoints are detected: what it is called, and the names of its keypoints."""

    noun: str
    names: tuple[str, ...]


PERSON: Final = Subject("person", NAMES)
ANIMAL: Final = Subject("animal", AP_10K)


class Detector(Protocol):
    """What sees keypoints in a region, as `Network`."""

    @property
    def fingerprint(self) -> str: ...
    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen: ...


@dataclass(frozen=True, eq=False)
class DetectionWindow:
    """A piece of a chain: N frames in its direction.

    uv, visibility, p_hips: (N, K, ...) as of Keypoints, NaN and 0 where nobody was seen.
    regions: (N, 4) where to look after each frame.
    lost_for: (N,) since how many frames the body is lost.
    masks: N, where the person is; None where nobody was seen.
    """

    uv: Array
    visibility: Array
    p_hips: Array
    regions: Array
    lost_for: NDArray[np.int64]
    masks: tuple[PersonMask | None, ...]

    def __len__(self) -> int:
        return len(self.uv)

    def region(self, row: int) -> Region:
        """Where to look after a frame."""
        x, y, side, turn = self.regions[row].tolist()
        return Region(x, y, side, turn)

    def __getitem__(self, rows: slice) -> DetectionWindow:
        """Some of its frames, or all in the other direction."""
        uv, visibility, p_hips = self.uv[rows], self.visibility[rows], self.p_hips[rows]
        regions, lost_for = self.regions[rows], self.lost_for[rows]
        return DetectionWindow(uv, visibility, p_hips, regions, lost_for, self.masks[rows])

    @classmethod
    def joined(cls, pieces: Sequence[DetectionWindow]) -> DetectionWindow:
        """Pieces that follow one another."""
        return cls(
            np.concatenate([p.uv for p in pieces]),
            np.concatenate([p.visibility for p in pieces]),
            np.concatenate([p.p_hips for p in pieces]),
            np.concatenate([p.regions for p in pieces]),
            np.concatenate([p.lost_for for p in pieces]),
            tuple(mask for p in pieces for mask in p.masks),
        )


class Rows:
    """A stretch while it grows: looked at frame by frame, each where the body was last."""

    def __init__(self, region: Region, lost_for: int = 0, subject: Subject = PERSON) -> None:
        self.region, self.lost_for, self.subject = region, lost_for, subject
        self._seen: list[Seen | None] = []
        self._regions: list[Region] = []
        self._lost_for: list[int] = []

    @classmethod
    def begun(
        cls,
        region: Region,
        network: Detector,
        picture: NDArray[np.uint8] | None,
        most: int,
        subject: Subject = PERSON,
    ) -> Rows:
        """One frame, looked at each time where the body was seen the last time, until that is a
        region of before: so many times at most."""
        rows, looked = cls(region, subject=subject), set[Region]()
        while len(looked) < most and (here := rows.region.rounded(LOOK_PARTS)) not in looked:
            looked.add(here)
            rows = cls(rows.region, subject=subject)
            rows.add(network, picture)
        return rows

    def add(self, network: Detector, picture: NDArray[np.uint8] | None) -> None:
        """The next frame; None where it cannot be decoded, or is not to be looked at."""
        detection = None
        if picture is not None:
            height, width = picture.shape[:2]
            if self.region.is_within(width, height):
                detection = network.infer(picture, self.region.rounded(LOOK_PARTS))
                if not _is_somebody(detection, width, height):
                    detection = None
        if detection is None:
            self.lost_for += 1
        else:
            self.region, self.lost_for = detection.next, 0
        self._seen.append(detection)
        self._regions.append(self.region)
        self._lost_for.append(self.lost_for)

    def skip(self) -> None:
        """The next frame, which is not looked at."""
        self._seen.append(None)
        self._regions.append(self.region)
        self._lost_for.append(self.lost_for)

    def stretch(self) -> DetectionWindow:
        points = len(self.subject.names)
        uv, metres = np.full((points, 2), np.nan), np.full((points, 3), np.nan)
        unseen = np.zeros(points)
        return DetectionWindow(
            _stack([uv if s is None else s.uv for s in self._seen], (points, 2)),
            _stack([unseen if s is None else s.visibility for s in self._seen], (points,)),
            _stack([metres if s is None else s.p_hips for s in self._seen], (points, 3)),
            _stack([np.array(astuple(region)) for region in self._regions], (4,)),
            np.array(self._lost_for, dtype=np.int64),
            tuple(None if s is None else s.mask for s in self._seen),
        )


def _is_somebody(detection: Seen, width: int, height: int) -> bool:
    finite = np.isfinite(detection.uv).all() and np.isfinite(detection.p_hips).all()
    return bool(
        finite and detection.presence >= LEAST_PRESENCE and detection.next.is_within(width, height)
    )


def _stack(rows: list[Array], shape: tuple[int, ...]) -> Array:
    return np.array(rows, dtype=float).reshape(len(rows), *shape)


MOST_LOOKS_AT_SEED: Final = 12
"""Of a body that lies or turns a cartwheel an upright box is mended in nine; of most, in three."""
PATIENCE: Final = 15
"""Frames that a chain looks for a lost body where it was last, before it ends."""
STRETCH: Final = 16
"""Frames that are kept together: from one multiple of it to the next, so that a chain that begins
between two is soon where another one was before."""
CLEARLY_BESIDE: Final = 0.25
"""Distance of regions at which two chains are on different bodies, or one of them is wrong."""

Frame: TypeAlias = Callable[[int], NDArray[np.uint8] | None]
"""A picture (H, W, 3), RGB, by its number; None where it cannot be decoded."""


@dataclass(frozen=True)
class Seed:
    """Where the body is at one frame."""

    frame: int
    region: Region

    @classmethod
    def of_box(cls, frame: int, box: Box, width: int, height: int) -> Seed:
        """A box drawn at a frame; KeypointError as `Region.of_box`."""
        return cls(frame, Region.of_box(box, width, height))

    @classmethod
    def of_pose(cls, frame: int, skeleton: Skeleton, pose: Pose, camera: Camera) -> Seed:
        """A body posed at a frame; KeypointError as `Region.of_pose`."""
        return cls(frame, Region.of_pose(skeleton, pose, camera))


class Kept(Protocol):
    """Stretches of earlier runs, by key."""

    def get(self, key: str) -> DetectionWindow | None: ...
    def put(self, key: str, stretch: DetectionWindow) -> None: ...


@dataclass(frozen=True)
class Progress:
    """Before each look. done, expected: frames, also those that are looked at a second time;
    `expected` may grow, by those where the chain backward is needed."""

    frame: int
    done: int
    expected: int


def detect(
    frame: Frame,
    frames: tuple[int, int],
    seeds: Sequence[Seed],
    network: Detector,
    *,
    report: Callable[[Progress], None] = lambda progress: None,
    film: str = "",
    kept: Kept | None = None,
    every_second: bool = False,
    subject: Subject = PERSON,
) -> Keypoints:
    """The keypoints of one body in all frames from the first to the last asked for.

    frames: first and last.
    seeds:  one or more, of different frames among these.
    report: called before each look; what it raises ends the work within a frame.
    film:   fingerprint of the pictures, under which stretches are kept; with `kept` alone.
    every_second: whether every second frame is enough, those between being means without a mask.
    subject: whom the network sees.

    Where nobody is found, and in frames that cannot be decoded, keypoints are NaN and unseen.
    KeypointError when no seed's region shows anybody.
    """
    ordered = in_order(seeds, frames)
    count = frames[1] - frames[0] + 1
    work = _DetectionRun(
        frame, network, report, film, kept, every_second, expected=count, subject=subject
    )
    starts = [start for start in map(work.start, ordered) if start is not None]
    if not starts:
        raise nobody(ordered, subject)
    keypoints = along_chains(work, starts, frames, subject)
    return with_means(keypoints) if every_second else keypoints


def in_order(seeds: Sequence[Seed], frames: tuple[int, int]) -> list[Seed]:
    """Seeds by their frames; ValueError unless these are different ones among those asked for."""
    first, last = frames
    ordered = sorted(seeds, key=lambda seed: seed.frame)
    numbers = [seed.frame for seed in ordered]
    inside = bool(numbers) and first <= numbers[0] <= numbers[-1] <= last
    if not inside or len(set(numbers)) < len(numbers):
        raise ValueError("seeds are of different frames among those asked for")
    return ordered


class Chains(Protocol):
    """What follows a body from where it was seen. expected: as of `Progress`."""

    expected: int

    def chain(self, start: Start, direction: int, last: int) -> DetectionWindow:
        """All frames after the start up to the last, in this direction."""


def along_chains(
    work: Chains, starts: Sequence[Start], frames: tuple[int, int], subject: Subject = PERSON
) -> Keypoints:
    """The keypoints of all frames from the first to the last, from one start or more, in order."""
    first, last = frames
    frames_found = _Found(first, last, subject)
    frames_found.put(starts[0].frame, -1, work.chain(starts[0], -1, first))
    for start, next_start in pairwise(starts):
        frames_found.between(start.frame, *_both_ways(work, start, next_start))
    frames_found.put(starts[-1].frame, 1, work.chain(starts[-1], 1, last))
    for start in starts:
        frames_found.put(start.frame - 1, 1, start.seen)
    return frames_found.keypoints()


def is_between(frame: int) -> bool:
    """Whether a frame is one of those between the ones that are looked at."""
    return frame % 2 == 1


def with_means(keypoints: Keypoints) -> Keypoints:
    """Put the mean of both neighbours, where they are known, into frames between."""
    uv, visibility, p_hips = keypoints.uv.copy(), keypoints.visibility.copy(), keypoints.p_hips
    assert p_hips is not None
    p_hips = p_hips.copy()
    for row in range(1, len(uv) - 1):
        around = [row - 1, row + 1]
        is_open = is_between(keypoints.first_frame + row) and np.isnan(uv[row]).all()
        if is_open and np.isfinite(uv[around]).all():
            for values in (uv, visibility, p_hips):
                values[row] = values[around].mean(axis=0)
    return replace(keypoints, uv=uv, visibility=visibility, p_hips=p_hips)


def nobody(seeds: Sequence[Seed], subject: Subject = PERSON) -> KeypointError:
    """What is said where no seed's region shows anybody."""
    where = f"frame{'s' if len(seeds) > 1 else ''} {listed([str(seed.frame) for seed in seeds])}"
    return KeypointError(
        f"No {subject.noun} was found at {where}: draw the box around the whole body, in a frame "
        "that shows it well."
    )


@dataclass(frozen=True, eq=False)
class Start:
    """A seed where somebody was seen; one frame, its region mended."""

    frame: int
    seen: DetectionWindow

    @property
    def region(self) -> Region:
        return self.seen.region(0)


def _both_ways(
    work: Chains, start: Start, next_start: Start
) -> tuple[DetectionWindow, DetectionWindow | None, int]:
    """Forward from one start to the frame of the other; backward, where that is needed, as far as
    the frame of the first, ordered by frame; and the step from which backward is taken."""
    forward = work.chain(start, 1, next_start.frame)
    if not forward.lost_for.any() and _is_near(forward, next_start):
        return forward, None, 0
    work.expected += next_start.frame - start.frame
    backward = work.chain(next_start, -1, start.frame)[::-1]
    return forward, backward, _change(forward, backward)


def _is_near(forward: DetectionWindow, start: Start) -> bool:
    return forward.region(-1).distance(start.region) < CLEARLY_BESIDE


def _change(forward: DetectionWindow, backward: DetectionWindow) -> int:
    """Where the body passes from one chain to the other: where both are nearest to each
    other.

    Row k of forward is of frame one + 1 + k, of backward of one + k.
    """
    steps = len(forward) - 1
    gaps = [
        forward.region(k).distance(backward.region(k + 1))
        if not (forward.lost_for[k] or backward.lost_for[k + 1])
        else np.inf
        for k in range(steps)
    ]
    if gaps and np.isfinite(min(gaps)):
        return int(np.argmin(gaps))
    # They never see it at once: each as far as it goes.
    lost = np.flatnonzero(forward.lost_for)
    return int(lost[0]) if len(lost) else steps


class _Found:
    """Rows of the frames asked for, filled in."""

    def __init__(self, first: int, last: int, subject: Subject) -> None:
        self._first, self._names = first, subject.names
        count, points = last - first + 1, len(subject.names)
        self._uv = np.full((count, points, 2), np.nan)
        self._visibility = np.zeros((count, points))
        self._p_hips = np.full((count, points, 3), np.nan)
        self._masks: list[PersonMask | None] = [None] * count

    def put(self, after: int, direction: int, rows: DetectionWindow) -> None:
        """The frames that follow this one in the direction."""
        for k in range(len(rows)):
            self._put(after + direction * (k + 1), rows, k)

    def between(
        self, first: int, forward: DetectionWindow, backward: DetectionWindow | None, change: int
    ) -> None:
        """The frames after the first, from two chains."""
        for k in range(len(forward) - 1):
            if backward is None or (k < change and not forward.lost_for[k]):
                self._put(first + 1 + k, forward, k)
            else:
                self._put(first + 1 + k, backward, k + 1)

    def _put(self, frame: int, rows: DetectionWindow, k: int) -> None:
        n = frame - self._first
        self._uv[n], self._visibility[n] = rows.uv[k], rows.visibility[k]
        self._p_hips[n], self._masks[n] = rows.p_hips[k], rows.masks[k]

    def keypoints(self) -> Keypoints:
        return Keypoints(
            self._first,
            self._names,
            self._uv,
            self._visibility,
            self._p_hips,
            masks=tuple(self._masks),
        )


@dataclass(eq=False)
class _DetectionRun:
    """One run: looks at frames, or takes what was kept."""

    frame: Frame
    network: Detector
    report: Callable[[Progress], None]
    film: str
    kept: Kept | None
    every_second: bool
    expected: int
    subject: Subject = PERSON
    done: int = 0

    def start(self, seed: Seed) -> Start | None:
        """The seed's frame, looked at several times; None where nobody is there."""

        def look() -> DetectionWindow:
            self._report(seed.frame)
            picture = self.frame(seed.frame)
            rows = Rows.begun(seed.region, self.network, picture, MOST_LOOKS_AT_SEED, self.subject)
            return rows.stretch()

        key = ("seed until it stays", seed.frame, astuple(seed.region))
        stretch = self._kept(key, 1, look)
        return None if stretch.lost_for[0] else Start(seed.frame, stretch)

    def chain(self, start: Start, direction: int, last: int) -> DetectionWindow:
        """All frames after the start up to the last, in this direction."""
        frames = range(start.frame + direction, last + direction, direction)
        region, lost_for = start.region, 0
        pieces = [Rows(region, subject=self.subject).stretch()]
        for piece_frames in frames_together(frames):
            piece = self._stretch(piece_frames, region, lost_for)
            pieces.append(piece)
            region, lost_for = piece.region(-1), int(piece.lost_for[-1])
        return DetectionWindow.joined(pieces)

    def _stretch(self, frames: range, region: Region, lost_for: int) -> DetectionWindow:
        def look() -> DetectionWindow:
            rows = Rows(region, lost_for, self.subject)
            for number in frames:
                self._report(number)
                may_skip = self.every_second and is_between(number) and number != frames[-1]
                if may_skip and not rows.lost_for:
                    rows.skip()
                    continue
                rows.add(self.network, self.frame(number) if rows.lost_for <= PATIENCE else None)
            return rows.stretch()

        key: tuple[object, ...] = (
            "piece",
            frames[0],
            frames.step,
            astuple(region.rounded(LOOK_PARTS)),
            lost_for,
        )
        if self.every_second:  # a longer piece may skip the frame at which this one ends
            key += ("every second", frames[-1] if is_between(frames[-1]) else None)
        return self._kept(key, len(frames), look)

    def _kept(
        self, key: tuple[object, ...], count: int, look: Callable[[], DetectionWindow]
    ) -> DetectionWindow:
        if self.kept is None:
            return look()
        text = json.dumps([self.film, self.network.fingerprint, repr(key)])
        name = hashlib.sha256(text.encode()).hexdigest()[:32]
        before = self.kept.get(name)
        if before is not None and len(before) >= count:
            self.done += count
            return before[:count]
        stretch = look()
        self.kept.put(name, stretch)
        return stretch

    def _report(self, frame: int) -> None:
        self.report(Progress(frame, self.done, max(self.expected, self.done + 1)))
        self.done += 1


def frames_together(frames: range) -> Iterator[range]:
    """Frames up to each multiple of `STRETCH`, in either direction."""
    ends = [k + 1 for k, frame in enumerate(frames) if frame % STRETCH == 0]
    for start, end in pairwise(sorted({0, *ends, len(frames)})):
        yield frames[start:end]
