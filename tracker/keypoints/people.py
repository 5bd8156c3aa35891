"""Detect the keypoints of several people in one film, so that nobody is taken for somebody else.

A network that looks where one person is sees whoever shows best there. People who pass each other
are therefore followed together, frame by frame, the nearest first: before the network looks at one
of them the others are painted out, and what lies on another body all the same is not believed.
Whoever is hidden is unseen meanwhile.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import astuple, dataclass, field, replace
from itertools import combinations, pairwise, product
from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.blazepose import Seen
from keypose.tracker.keypoints.crossings import (
    APART,
    JOINT_COLUMNS,
    person_changes,
    region_around,
    trunk_distance,
)
from keypose.tracker.keypoints.detect import (
    MOST_LOOKS_AT_SEED,
    PATIENCE,
    DetectionWindow,
    Detector,
    Frame,
    Kept,
    Progress,
    Rows,
    Seed,
    Start,
    along_chains,
    detect,
    frames_together,
    in_order,
    is_between,
    nobody,
    with_means,
)
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.keypoints.person_mask import PersonMask
from keypose.tracker.keypoints.region import Region, around_the_same

KEPT_AS: Final = "people 2"
"""Names what was seen by how people are looked at: another number where that is another way."""
GREY: Final = 127
"""Level of red, green and blue with which people are painted out."""
LIKELY: Final = 0.5
"""What is more likely than this another person is painted out, unless it is as likely the own."""
NEWEST: Final = 0.3
"""Share of the newest step in the mean speed of a person."""
LIES_ON: Final = 0.1
"""Joints lie on a body from which they are so far away in the median, a share of the region's
side."""
MOST_HIDDEN: Final = 0.6
"""Of whom more of the joints lie where others were painted out, nobody is: a network sees a person
in the grey of one."""
_NOWHERE: Final = Region(0.0, 0.0, 1.0)
"""Where somebody is who was not seen yet."""


def detect_people(
    frame: Frame,
    frames: tuple[int, int],
    seeds_by_person: Sequence[Sequence[Seed]],
    network: Detector,
    *,
    report: Callable[[Progress], None] = lambda progress: None,
    film: str = "",
    kept: Kept | None = None,
    every_second: bool = False,
) -> list[Keypoints]:
    """The keypoints of several people in all frames from the first to the last, in their order; of
    one alone as `detect` finds them.

    seeds_by_person: of each one or more, of different frames.  All else is as of `detect`;
    `Progress` counts each person's frames.

    Where somebody is hidden by another, keypoints are NaN and unseen. KeypointError when no seed's
    region of somebody shows anybody, or when two people's seeds show the same body.
    """
    if len(seeds_by_person) == 1:
        alone = detect(
            frame,
            frames,
            seeds_by_person[0],
            network,
            report=report,
            film=film,
            kept=kept,
            every_second=every_second,
        )
        return [alone]
    run = _PeopleRun(frame, frames, network, report, film, kept, every_second)
    run.begin([in_order(seeds, frames) for seeds in seeds_by_person])
    people = [
        along_chains(_ChainsOfOne(run, index), starts, frames)
        for index, starts in enumerate(run.starts)
    ]
    return [with_means(keypoints) for keypoints in people] if every_second else people


def people_changes(
    frame: Frame,
    people: Sequence[Keypoints],
    seeds: Sequence[int],
    network: Detector,
    report: Callable[[int, int], None] = lambda done, expected: None,
    *,
    every_second: bool = False,
) -> list[tuple[int, ...]]:
    """The frames from which on each of several people may be another one than before, as
    `person_changes` finds them of one: followed back together from where they were seen last.

    people: as `detect_people` found them from seeds at these frames, of anybody.  report: as of
    `person_changes`.
    """
    if len(people) == 1:
        return [person_changes(frame, people[0], seeds, network, report)]

    def reported(progress: Progress) -> None:
        report(progress.done, progress.expected)

    changes: list[list[int]] = [[] for _ in people]
    first, last = people[0].first_frame, people[0].last_frame
    for end, at, step in ((last, max(seeds), -1), (first, min(seeds), 1)):
        span = min(at, end), max(at, end)
        run = _PeopleRun(frame, span, network, reported, "", None, every_second)
        seen_last = [_seen_last(keypoints, end, at, step) for keypoints in people]
        run.starts = [[] if start is None else [start] for start in seen_last]
        if not any(run.starts):
            continue
        sweep = run.sweep(step)
        for index, (keypoints, start) in enumerate(zip(people, seen_last, strict=True)):
            change = None if start is None else _parting(keypoints, sweep, index, start.frame)
            changes[index] += [] if change is None else [change]
    return [tuple(sorted(set(each))) for each in changes]


def _seen_last(keypoints: Keypoints, end: int, at: int, step: int) -> Start | None:
    """Where a person is seen with a mask, from the end of the frames on toward a seed; None where
    they are not."""
    for number in range(end, at, step):
        mask, row = keypoints.mask(number), number - keypoints.first_frame
        if mask is not None and np.isfinite(keypoints.uv[row]).all():
            return _start_of(keypoints, number)
    return None


def _start_of(keypoints: Keypoints, number: int) -> Start:
    row = slice(number - keypoints.first_frame, number - keypoints.first_frame + 1)
    assert keypoints.p_hips is not None
    assert keypoints.masks is not None
    regions = np.array([astuple(region_around(keypoints.uv[row][0]))])
    seen_rows = DetectionWindow(
        keypoints.uv[row],
        keypoints.visibility[row],
        keypoints.p_hips[row],
        regions,
        np.zeros(1, np.int64),
        keypoints.masks[row],
    )
    return Start(number, seen_rows)


def _parting(keypoints: Keypoints, sweep: _Sweep, index: int, begins: int) -> int | None:
    """The first frame of a sweep, after the one where a person begins in it, at which the person
    is elsewhere than they were seen; the frame after it in the film. None where they never are."""
    rows = sweep.rows[index]
    for k in range(len(rows)):
        number = sweep.begins + sweep.direction * (k + 1)
        if (number - begins) * sweep.direction <= 0:
            continue
        before = keypoints.uv[number - keypoints.first_frame]
        is_known = np.isfinite(before).all() and np.isfinite(rows.uv[k]).all()
        if is_known and trunk_distance(before, rows.uv[k]) > APART:
            return max(number, number - sweep.direction)
    return None


@dataclass(frozen=True, eq=False)
class _Place:
    """Where a person was seen last. frame: when.  uv: (33, 2).  lost_for: as of `DetectionWindow`.
    velocity: (2,) pixels a frame, of the body in the picture.
    """

    frame: int
    region: Region
    lost_for: int
    uv: Array
    mask: PersonMask
    velocity: Array = field(default_factory=lambda: np.zeros(2))

    @classmethod
    def at_start(cls, start: Start) -> _Place:
        (mask,) = start.seen.masks
        assert mask is not None  # somebody is seen at a start
        return cls(start.frame, start.region, 0, start.seen.uv[0], mask)

    def after(self, frames: range, rows: DetectionWindow) -> _Place:
        """Where the person was seen last when these frames are done."""
        place = self
        for k, number in enumerate(frames):
            mask = rows.masks[k]
            if mask is not None:
                place = place.moved_to(number, rows.region(k), rows.uv[k], mask)
        return replace(place, region=rows.region(-1), lost_for=int(rows.lost_for[-1]))

    def moved_to(self, frame: int, region: Region, uv: Array, mask: PersonMask) -> _Place:
        """The person seen anew."""
        moved = np.median(uv[JOINT_COLUMNS] - self.uv[JOINT_COLUMNS], axis=0) / (frame - self.frame)
        velocity = self.velocity + NEWEST * (moved - self.velocity)
        return _Place(frame, region, 0, uv, mask, velocity)

    def expected(self, frame: int) -> _Place:
        """Where the person is at a frame if they go on as before."""
        shift = (frame - self.frame) * self.velocity
        mask = replace(self.mask, region=_moved(self.mask.region, shift))
        return replace(self, uv=self.uv + shift, mask=mask, region=_moved(self.region, shift))

    def facts(self) -> tuple[object, ...]:
        """All that decides what is seen next."""
        digest = hashlib.sha256(self.uv.tobytes() + self.mask.packed).hexdigest()
        places = astuple(self.region), astuple(self.mask.region), self.velocity.tolist()
        return self.frame, self.lost_for, *places, digest


def _moved(region: Region, shift: Array) -> Region:
    x, y = (np.array([region.x, region.y]) + shift).tolist()
    return replace(region, x=x, y=y)


class _AmongOthers:
    """A network that looks at one of several people: `last_seen` is the newest look believed."""

    def __init__(self, network: Detector, own: _Place, others: Sequence[_Place]) -> None:
        self._network, self._own = network, own
        self._others = [place for place in others if not place.lost_for]
        self.fingerprint = network.fingerprint
        self.last_seen: Seen | None = None

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        """What the network sees where the others are painted out; with a presence of 0 where that
        lies on one of them."""
        near = [place for place in self._others if _meet(region, place.mask.region)]
        masks = [place.mask for place in near]
        own_mask = None if self._own.lost_for else self._own.mask
        area = painted_area(picture, masks, own_mask)
        detection = self._network.infer(painted_out(picture, area), region)
        if any(self._lies_on(detection, place) for place in near):
            return replace(detection, presence=0.0)
        if detection.mask is not None and area.any():
            detection = replace(detection, mask=detection.mask.without(area))
        self.last_seen = detection
        return detection

    def is_beside_somebody(self, region: Region) -> bool:
        """Whether somebody else is near enough to hide who is in a region."""
        return any(_meet(region, place.mask.region) for place in self._others)

    def _lies_on(self, detection: Seen, place: _Place) -> bool:
        away = _apart(detection.uv, place.uv)
        return away < LIES_ON * place.region.side and away < _apart(detection.uv, self._own.uv)


def painted_area(
    picture: NDArray[np.uint8], others: Sequence[PersonMask], own: PersonMask | None
) -> NDArray[np.bool_]:
    """Where in a picture (H, W, 3) the people of some masks are, as far as these are not the own:
    (H, W)."""
    height, width = picture.shape[:2]
    area = np.zeros((height, width), np.bool_)
    own_share = 0.0 if own is None else own.in_picture(width, height)
    for mask in others:
        share = mask.in_picture(width, height)
        area |= (share > LIKELY) & (share > own_share)
    return area


def painted_out(picture: NDArray[np.uint8], area: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """A picture (H, W, 3) with an area (H, W) grey."""
    if not area.any():
        return picture
    painted = picture.copy()
    painted[area] = GREY
    return painted


def _under(uv: Array, masks: Sequence[PersonMask], picture: NDArray[np.uint8]) -> float:
    """The share of joints (33, 2) that lie where some of the people of masks are."""
    height, width = picture.shape[:2]
    at = np.nan_to_num(uv[JOINT_COLUMNS]).round().astype(int)
    inside = (at >= 0).all(axis=1) & (at < (width, height)).all(axis=1)
    x, y = np.clip(at, 0, (width - 1, height - 1)).T
    covered = [mask.in_picture(width, height)[y, x] > LIKELY for mask in masks]
    return float((inside & np.any(covered, axis=0)).mean()) if masks else 0.0


def _shows_same(first: Start, second: Start) -> bool:
    reach = LIES_ON * min(first.region.side, second.region.side)
    return _apart(first.seen.uv[0], second.seen.uv[0]) < reach


def _apart(uv: Array, uv_before: Array) -> float:
    """The median distance of joints, pixels."""
    return float(np.median(np.linalg.norm(uv[JOINT_COLUMNS] - uv_before[JOINT_COLUMNS], axis=1)))


def _meet(first: Region, second: Region) -> bool:
    """Whether the circles around two regions meet."""
    reach = (first.side + second.side) / np.sqrt(2)
    return bool(np.hypot(first.x - second.x, first.y - second.y) < reach)


@dataclass(frozen=True, eq=False)
class _Sweep:
    """All people followed in one direction: rows of each from the frame after the earliest start
    on; those before a person's own start hold nothing."""

    begins: int
    direction: int
    rows: tuple[DetectionWindow, ...]


@dataclass(eq=False)
class _PeopleRun:
    """One run over a film: looks at frames, or takes what was kept."""

    frame: Frame
    frames: tuple[int, int]
    network: Detector
    report: Callable[[Progress], None]
    film: str
    kept: Kept | None
    every_second: bool
    starts: list[list[Start]] = field(default_factory=list)
    expected: int = 0
    done: int = 0
    _sweeps: dict[int, _Sweep] = field(default_factory=dict)

    def begin(self, seeds_by_person: Sequence[Sequence[Seed]]) -> None:
        """Look at everybody's seeds, first at those from which the network finds who is there: who
        is partly hidden, so that it finds somebody else, is looked at when that one is known."""
        self.starts = [[] for _ in seeds_by_person]
        seeds = [(index, seed) for index, own in enumerate(seeds_by_person) for seed in own]
        for index, seed in sorted(seeds, key=lambda each: self._goes_away(each[1])):
            others = [
                start
                for whose, own_starts in enumerate(self.starts)
                for start in own_starts
                if whose != index and start.frame == seed.frame
            ]
            start = self._start(seed, others)
            if start is not None:
                self.starts[index].append(start)
        self._exchange_starts({(index, seed.frame): seed.region for index, seed in seeds})
        for seeds_of_one, own_starts in zip(seeds_by_person, self.starts, strict=True):
            if not own_starts:
                raise nobody(seeds_of_one)
            own_starts.sort(key=lambda start: start.frame)

    def _exchange_starts(self, regions: Mapping[tuple[int, int], Region]) -> None:
        """Exchange what was seen from two seeds at one frame, where each is nearer to the region of
        the other seed."""
        for first, second in combinations(range(len(self.starts)), 2):
            for m, n in product(range(len(self.starts[first])), range(len(self.starts[second]))):
                a, b = self.starts[first][m], self.starts[second][n]
                if a.frame != b.frame:
                    continue
                here, there = regions[first, a.frame], regions[second, a.frame]
                own = a.region.distance(here) + b.region.distance(there)
                if a.region.distance(there) + b.region.distance(here) < own:
                    self.starts[first][m], self.starts[second][n] = b, a

    def _goes_away(self, seed: Seed) -> float:
        """How far a network that nobody is painted out for ends from a seed's region."""
        self._report(seed.frame)
        begun = Rows.begun(
            seed.region, self.network, self.frame(seed.frame), MOST_LOOKS_AT_SEED
        ).stretch()
        return begun.region(0).distance(seed.region)

    def _start(self, seed: Seed, others: Sequence[Start]) -> Start | None:
        """The seed's frame, looked at several times without those who are known there."""
        self._report(seed.frame)
        picture = self.frame(seed.frame)
        if picture is None:
            return None
        masks = [mask for start in others for mask in start.seen.masks if mask is not None]
        shown = painted_out(picture, painted_area(picture, masks, None))
        stretch = Rows.begun(seed.region, self.network, shown, MOST_LOOKS_AT_SEED).stretch()
        hidden = others and _under(stretch.uv[0], masks, shown) > MOST_HIDDEN
        if hidden or (others and stretch.lost_for[0]):  # somebody who was painted out?
            stretch = Rows.begun(seed.region, self.network, picture, MOST_LOOKS_AT_SEED).stretch()
        if stretch.lost_for[0]:
            return None
        start = Start(seed.frame, stretch)
        if any(_shows_same(start, each) for each in others):
            raise around_the_same(seed.frame)
        return start

    def sweep(self, direction: int) -> _Sweep:
        """All people followed in one direction, each from every one of their starts on."""
        if direction not in self._sweeps:
            self._sweeps[direction] = self._swept(direction)
        return self._sweeps[direction]

    def _swept(self, direction: int) -> _Sweep:
        begins = min(
            (own_starts[::direction][0].frame for own_starts in self.starts if own_starts),
            key=lambda number: number * direction,
        )
        last = self.frames[1] if direction > 0 else self.frames[0]
        frames = range(begins + direction, last + direction, direction)
        self.expected += len(self.starts) * len(frames)
        places: list[_Place | None] = [None] * len(self.starts)
        self._put_starts(begins, places)
        rows_of_all = [[Rows(_NOWHERE).stretch()] for _ in places]
        for piece in self._pieces(frames):
            for index, rows in enumerate(self._piece(piece, places)):
                rows_of_all[index].append(rows)
                place = places[index]
                places[index] = None if place is None else place.after(piece, rows)
            self._put_starts(piece[-1], places)
        return _Sweep(begins, direction, tuple(map(DetectionWindow.joined, rows_of_all)))

    def _put_starts(self, number: int, places: list[_Place | None]) -> None:
        """Put people where they start at a frame."""
        for index, own_starts in enumerate(self.starts):
            for start in own_starts:
                if start.frame == number:
                    places[index] = _Place.at_start(start)

    def _pieces(self, frames: range) -> Iterator[range]:
        """Frames that are kept together; where anybody starts, a piece ends."""
        starts = {start.frame for own_starts in self.starts for start in own_starts}
        for piece in frames_together(frames):
            ends = [k + 1 for k, number in enumerate(piece) if number in starts]
            for begin, end in pairwise(sorted({0, *ends, len(piece)})):
                yield piece[begin:end]

    def _piece(self, frames: range, places: Sequence[_Place | None]) -> list[DetectionWindow]:
        """The rows of everybody in these frames."""
        facts = [None if place is None else place.facts() for place in places]
        last = frames[-1] if self.every_second and is_between(frames[-1]) else None
        how = (KEPT_AS, frames[0], frames.step, self.every_second, last, facts)
        text = json.dumps([self.film, self.network.fingerprint, repr(how)])
        name = hashlib.sha256(text.encode()).hexdigest()[:32]
        kept_rows = [
            self.kept.get(f"{name}-{index}") if self.kept is not None else None
            for index in range(len(places))
        ]
        whole = [rows[: len(frames)] for rows in kept_rows if rows is not None]
        if len(whole) == len(places) and all(len(rows) == len(frames) for rows in whole):
            self.done += len(places) * len(frames)
            return whole
        looked = self._looked(frames, places)
        if self.kept is not None:
            for index, rows in enumerate(looked):
                self.kept.put(f"{name}-{index}", rows)
        return looked

    def _looked(self, frames: range, places: Sequence[_Place | None]) -> list[DetectionWindow]:
        now = list(places)
        rows = [
            Rows(_NOWHERE) if place is None else Rows(place.region, place.lost_for)
            for place in places
        ]
        for number in frames:
            may_skip = self.every_second and is_between(number) and number != frames[-1]
            may_skip = may_skip and not any(
                place and 0 < place.lost_for <= PATIENCE for place in now
            )
            for index in _nearest_first(now):
                self._report(number)
                place = now[index]
                if place is None or may_skip:
                    rows[index].skip()
                    continue
                others = [each for n, each in enumerate(now) if n != index and each is not None]
                now[index] = self._look(number, rows[index], place, others)
        return [each.stretch() for each in rows]

    def _look(self, number: int, rows: Rows, place: _Place, others: Sequence[_Place]) -> _Place:
        """Look at one person; where they are then."""
        expected = place.expected(number)
        network = _AmongOthers(self.network, expected, [each.expected(number) for each in others])
        if place.lost_for and network.is_beside_somebody(expected.region):
            rows.region = expected.region  # behind them they go on
        may_look = rows.lost_for <= PATIENCE or network.is_beside_somebody(rows.region)
        rows.add(network, self.frame(number) if may_look else None)
        seen_last = network.last_seen
        if seen_last is None or rows.lost_for:
            return replace(place, lost_for=rows.lost_for)
        assert seen_last.mask is not None  # the networks that see people have one
        return place.moved_to(number, seen_last.next, seen_last.uv, seen_last.mask)

    def _report(self, frame: int) -> None:
        self.report(Progress(frame, self.done, max(self.expected, self.done + 1)))
        self.done += 1


def _nearest_first(places: Sequence[_Place | None]) -> list[int]:
    """Indices of people, those who are lost last."""

    def rank(index: int) -> tuple[bool, float]:
        place = places[index]
        return (True, 0.0) if place is None else (place.lost_for > 0, -place.region.side)

    return sorted(range(len(places)), key=rank)


@dataclass(eq=False)
class _ChainsOfOne:
    """The chains of one of the people, as parts of the sweeps of all."""

    run: _PeopleRun
    index: int
    expected: int = 0  # the run counts

    def chain(self, start: Start, direction: int, last: int) -> DetectionWindow:
        """All frames after the start up to the last, in this direction."""
        if start.frame == last:
            return Rows(start.region).stretch()
        sweep = self.run.sweep(direction)
        first = (start.frame - sweep.begins) * direction
        return sweep.rows[self.index][first : (last - sweep.begins) * direction]
