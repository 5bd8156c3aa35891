"""Over which stretches of a session's motion the last solve in space goes, and for what.

A stretch is a run of neighbouring segments whose results fit the session and are whole. Its key is
a digest of all that the solve is given, so that a result of the same key is the same motion.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from keypose.tracker.body.body import Body
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

    key: of all that the solve is given.  pins: those within, clipped to its frames.
    """

    key: str
    segments: tuple[SegmentResult, ...]
    pins: tuple[Pin, ...]

    @property
    def span(self) -> Span:
        return self.segments[0].first, self.segments[-1].last


class Usable(NamedTuple):
    """What identifies a segment's result as tracked, if it can be used here."""

    first: int
    last: int
    key: str
    quality: Quality


def stretches(session: Session, fitting: Mapping[Span, SegmentResult]) -> list[SegmentRun]:
    """What there is to solve."""
    rows = [
        Usable(*span, segment_result.key, segment_result.quality)
        for span, segment_result in fitting.items()
        if segment_result.finished
        and not segment_result.missing
        and segment_result.quality != "preview"
    ]
    return [
        SegmentRun(key, tuple(fitting[row.first, row.last] for row in run), pins)
        for key, run, pins in _wanted(session, rows)
    ]


def stretch_keys(session: Session, rows: Sequence[Usable]) -> set[str]:
    """The keys of the stretches that these segments make up."""
    return {key for key, _, _ in _wanted(session, rows)}


def _wanted(
    session: Session, rows: Sequence[Usable]
) -> Iterator[tuple[str, list[Usable], tuple[Pin, ...]]]:
    """Key, segments and pins of each stretch; none where a session asks for neither pins nor
    smoothness, or for the printed method, or has no film."""
    wanted = session.settings.smooth or session.subject.pins
    if not wanted or session.settings.method != "keypose" or session.view.surface is not None:
        return
    for run in _runs(sorted(rows), session.subject.pins):
        span = run[0].first, run[-1].last
        pins = pins_within(session.subject.pins, span)
        if pins or session.settings.smooth:
            yield _key(session, run, pins, span), run, pins


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


def _key(session: Session, run: Sequence[Usable], pins: Sequence[Pin], span: Span) -> str:
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
    ]
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


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
