"""Over which stretches of a session's motion the last solve in space goes, and for what.

A stretch is a run of neighbouring segments whose results fit the session and are whole. Its key is
a digest of all that the solve is given, so that a result of the same key is the same motion.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from keypose.tracker.body.body import Body
from keypose.tracker.session.bonds import Bond
from keypose.tracker.session.keyframe import Keyframe
from keypose.tracker.session.pins import Pin, pins_within
from keypose.tracker.session.schema import Session
from keypose.tracker.session.settings import Quality
from keypose.tracker.storage.fingerprints import DECIMALS, Span
from keypose.tracker.tracking.result import SegmentResult

STRETCH_KEY_VERSION = 2
"""Of the solve: another one finds another motion."""
FILMS_VERSION = 1
"""The same of what is compared with further films."""
LONGEST = 900
"""Frames in one solve; a longer stretch is divided at keyframes, if possible between pins."""


@dataclass(frozen=True, eq=False)
class SegmentRun:
    """Neighbouring segments that are solved together.

    key: of all that the solve is given.  pins: those within, clipped to its frames.  bonds: those
    that hold there.  beside: the segments as tracked of the bodies at their other ends, by id.
    """

    key: str
    segments: tuple[SegmentResult, ...]
    pins: tuple[Pin, ...]
    bonds: tuple[Bond, ...] = ()
    beside: Mapping[str, tuple[SegmentResult, ...]] = field(default_factory=dict)

    @property
    def span(self) -> Span:
        return self.segments[0].first, self.segments[-1].last


class Usable(NamedTuple):
    """What identifies a segment's result as tracked, if it can be used here."""

    first: int
    last: int
    key: str
    quality: Quality


RowsBeside: TypeAlias = Mapping[str, Sequence[Usable]]
"""The segments of other bodies, by id."""


def stretches(
    session: Session,
    fitting: Mapping[Span, SegmentResult],
    beside: Mapping[str, Mapping[Span, SegmentResult]] | None = None,
) -> list[SegmentRun]:
    """What there is to solve of the body that is posed. beside: the results as tracked of those
    that bonds join it to, by id."""
    beside = beside or {}
    rows_beside = {body_id: _usable(results) for body_id, results in beside.items()}
    return [
        SegmentRun(
            wanted.key,
            tuple(fitting[row.first, row.last] for row in wanted.rows),
            wanted.pins,
            wanted.bonds,
            {
                body_id: tuple(beside[body_id][row.first, row.last] for row in rows)
                for body_id, rows in wanted.beside.items()
            },
        )
        for wanted in _wanted(session, _usable(fitting), rows_beside)
    ]


def _usable(fitting: Mapping[Span, SegmentResult]) -> list[Usable]:
    return [
        Usable(*span, segment_result.key, segment_result.quality)
        for span, segment_result in fitting.items()
        if segment_result.finished
        and not segment_result.missing
        and segment_result.quality != "preview"
    ]


def stretch_keys(
    session: Session, rows: Sequence[Usable], beside: RowsBeside | None = None
) -> set[str]:
    """The keys of the stretches that these segments make up, with those of the bodies beside."""
    return {wanted.key for wanted in _wanted(session, rows, beside or {})}


class Wanted(NamedTuple):
    """A stretch by its key, its segments, and what it is solved with."""

    key: str
    rows: list[Usable]
    pins: tuple[Pin, ...]
    bonds: tuple[Bond, ...]
    beside: RowsBeside


def _wanted(session: Session, rows: Sequence[Usable], beside: RowsBeside) -> Iterator[Wanted]:
    """The stretches of a session; none where it asks for neither pins, bonds nor smoothness, or for
    the printed method, or has no film."""
    own_bonds = [bond for bond in session.bonds if session.subject.id in bond.bodies]
    wanted = session.settings.smooth or session.subject.pins or own_bonds
    if not wanted or session.settings.method != "keypose" or session.view.surface is not None:
        return
    for run in _runs(sorted(rows), session.subject.pins):
        span = run[0].first, run[-1].last
        pins = pins_within(session.subject.pins, span)
        bonds, joined = _joined(own_bonds, session.subject.id, span, beside)
        if pins or bonds or session.settings.smooth:
            key = _key(session, run, pins, span, (bonds, joined))
            yield Wanted(key, run, pins, bonds, joined)


def _joined(
    bonds: Sequence[Bond], body_id: str, span: Span, beside: RowsBeside
) -> tuple[tuple[Bond, ...], RowsBeside]:
    """The bonds that hold within a span, clipped to it and to where the other body was tracked, and
    the segments of these bodies; a bond to one that was not tracked there holds nothing."""
    holding: list[Bond] = []
    joined: dict[str, Sequence[Usable]] = {}
    for bond in bonds:
        others = [each for each in bond.bodies if each != body_id]
        within = [row for each in others for row in sorted(beside.get(each, ()))]
        within = [row for row in within if bond.overlaps((row.first, row.last))]
        first, last = max(bond.first_frame, span[0]), min(bond.last_frame, span[1])
        if others:
            first = max(first, min((row.first for row in within), default=last))
            last = min(last, max((row.last for row in within), default=first))
        if first < last and all(a.last == b.first for a, b in pairwise(within)):
            holding.append(bond.model_copy(update={"first_frame": first, "last_frame": last}))
            joined |= {each: sorted({*joined.get(each, ()), *within}) for each in others}
    return tuple(holding), joined


def _runs(rows: Sequence[Usable], pins: Sequence[Pin]) -> Iterator[list[Usable]]:
    """Neighbours that are solved together."""
    run: list[Usable] = []
    for row in rows:
        held = any(pin.first_frame < row.first < pin.last_frame for pin in pins)
        if run and run[-1].last == row.first and (held or row.last - run[0].first < LONGEST):
            run.append(row)
            continue
        if run:
            yield run
        run = [row]
    if run:
        yield run


def _key(
    session: Session,
    run: Sequence[Usable],
    pins: Sequence[Pin],
    span: Span,
    held: tuple[tuple[Bond, ...], RowsBeside],
) -> str:
    keyframes = keyframes_within(session, *span)
    soft = [keyframe.frame for keyframe in keyframes if keyframe.soft]
    in_depth = [keyframe.frame for keyframe in keyframes if keyframe.soft == "depth"]
    content = [
        STRETCH_KEY_VERSION,
        [(row.key, row.quality) for row in run],
        [pin.model_dump(mode="json") for pin in pins],
        [session.world.floor_m, session.world.up_world, bool(session.settings.smooth), soft],
        [part.limits_deg for part in session.subject.body.parts],  # no segment's key has them
        *_twists(session.subject.body),
        *([{"soft in depth": in_depth}] if in_depth else []),
        *(
            [session.view.video.repeats.model_dump(mode="json")]
            if session.view.video.repeats
            else []
        ),
        [keyframe.time_s for keyframe in (keyframes[0], keyframes[-1])],
        *_camera(session, span),
        *([{"films": FILMS_VERSION}] if session.views[1:] else []),  # which segments' keys have
        *_bonded(session, *held),
    ]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _bonded(session: Session, bonds: Sequence[Bond], beside: RowsBeside) -> list[Any]:
    """Bonds, and what the motions beside are made of; nothing where none holds."""
    if not bonds:
        return []
    pinned = {body.id: [p.model_dump(mode="json") for p in body.pins] for body in session.bodies}
    rows = {
        body_id: [[(row.key, row.quality) for row in rows], pinned[body_id]]
        for body_id, rows in beside.items()
    }
    return [{"bonds": [bond.model_dump(mode="json") for bond in bonds], "beside": rows}]


def _camera(session: Session, span: Span) -> list[Any]:
    """Where the camera was over a span; nothing where it stands still."""
    path = session.camera_path
    if path is None:
        return []
    over = np.round(path.between(*span).Ts_camera_world, DECIMALS) + 0.0  # as any machine has it
    return [{"camera": hashlib.sha256(over.tobytes()).hexdigest()}]


def _twists(body: Body) -> list[Any]:
    """Limits of twist as a person's body has them; nothing of one without, as before there were
    any."""
    twists = {part.name: part.twist.model_dump(mode="json") for part in body.parts if part.twist}
    return [twists] if twists else []


def keyframes_within(session: Session, first: int, last: int) -> list[Keyframe]:
    """The keyframes of a span, its ends among them."""
    return [keyframe for keyframe in session.subject.keyframes if first <= keyframe.frame <= last]
