"""What is up, by each of the ways that show it, of films and rendered people whose truth is known.

Films of cameras that were calibrated are drafted with nothing known of up, every thirtieth draft
accepted as it is, and tracked: lines, balance and stances each say what is up, and all of them
together. The published calibration of `several` is itself 1–2° off. Rendered people stand, walk and
jump on a level floor before a camera that looks down by 10°, without lines. Each cell is by how
many degrees it is off, and its ±, two standard deviations.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final
from xml.etree import ElementTree

import numpy as np

from bench.keeping import DATA, Absent, data_folder
from bench.markers import PHONE_DEG
from bench.standing import run_quietly
from bench.standing_cases import CASES, made
from bench.table import Report, Table
from keypose.app.editor.documents import softened, with_drafts, with_keyframes
from keypose.app.jobs.draft import drafted
from keypose.app.jobs.film_session import (
    WhoIsDrafted,
    begun_session,
    opened_film,
    with_draft_kept,
)
from keypose.app.jobs.find_up import upright_lines
from keypose.app.orders.film import FilmOrder, FilmToDraft
from keypose.app.words.up import off_deg
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.geometry.up import UnsureUp
from keypose.tracker.operations.find_camera import with_scale
from keypose.tracker.operations.find_up import estimated_up, evidence_of_motion, motions_of
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session, open_video_of, save_session
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.storage.results import load_results
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video.upright_lines import UprightLines

EVERY: Final = 30
WAYS: Final = ("lines", "person", "feet", "all")
MOST_OUTSIDE: Final = 0.1
"""The share of the ± that may miss the truth."""
MOST_SPREAD = 1.3
LEAST_SPREAD = 0.4
"""Of the errors in tilt as multiples of their standard deviation, root mean square: more is too
sure of itself, less too timid."""
AHEAD: Final = np.array([0.0, 0.0, 1.0])
"""Along which up moves with the tilt."""
SHOWN_RAD: Final = np.radians(20.0)
"""A tilt that is less sure is not shown at all."""
NOT_LEVEL: Final = ("stairs",)
"""Here feet do not stand level: what they show is to disagree."""


@dataclass(frozen=True)
class Filmed:
    """A film whose camera is known: the box of the person at frame 40, its frames and its lens."""

    path: Path
    box: tuple[float, float, float, float]
    frames: Span
    view_deg: float
    up: Array


@dataclass(frozen=True)
class Hits:
    """How far each way was off.  inside: whether its ± covers the truth.  shares: of the tilt, as a
    multiple of its standard deviation."""

    inside: dict[str, list[bool]] = field(default_factory=lambda: defaultdict(list))
    shares: dict[str, list[float]] = field(default_factory=lambda: defaultdict(list))


def up(report: Report) -> None:
    """The whole group."""
    table, hits = report.table("degrees off ± said", "true tilt", *WAYS, "apart"), Hits()
    with suppress(Absent):
        for name, film in _films():
            _film(name, film, table, hits)
    for name in CASES:
        case = made(name)
        session = with_scale(case.session, case.fitting)
        _row(name, case.up, session, case.fitting, None, table, hits)
    for way in WAYS:
        outside = 1 - float(np.mean(hits.inside[way] or [True]))
        spread = float(np.sqrt(np.mean(np.square(hits.shares[way] or [1.0]))))
        report.expect(f"{way}: share outside its ±", outside, MOST_OUTSIDE)
        report.expect(f"{way}: rms of error / σ", spread, MOST_SPREAD)
        report.expect(f"{way}: rms of σ / error", 1 / spread, 1 / LEAST_SPREAD)


def _films() -> Iterator[tuple[str, Filmed]]:
    person = data_folder("person")
    meta = json.loads((person / "meta.json").read_text())["camera"]
    R = np.array(meta["R_world_to_cam"])
    view = _view_deg(meta["K"][0][0], meta["height"])
    yield (
        "person",
        Filmed(person / "cam03_544x960.mp4", (200, 200, 450, 800), (0, 99), view, R[:, 2]),
    )
    for clip, box, frames in (
        ("walk", (309, 544, 579, 1074), (0, 74)),
        ("squat", (178, 527, 478, 1130), (0, 240)),
    ):
        folder = DATA / "opencap" / clip
        R = np.array(json.loads((folder / "camera_solved.json").read_text())["R_camera_ground"])
        yield f"phone, {clip}", Filmed(folder / "video.mp4", box, frames, PHONE_DEG, R[:, 1])
    boxes = {"single_cam02": (100, 343, 807, 1206), "single_cam03": (198, 319, 818, 1317),
             "multi_cam02": (206, 344, 804, 1208), "multi_cam03": (56, 514, 445, 1102)}  # fmt: skip
    for name, box in boxes.items():
        view, truth = _qualisys(DATA / "several" / "qca.txt", name[-5:])
        yield name, Filmed(DATA / "several" / f"{name}.mp4", box, (0, 99), view, truth)


def _qualisys(path: Path, serial: str) -> tuple[float, Array]:
    """Field of view of a camera of 1088 × 1920, and what is up for it, which Qualisys' cameras see
    with y up and z backward."""
    found = next(c for c in ElementTree.parse(path).iter("camera") if c.get("serial") == serial)
    intrinsic, turn = found.find("intrinsic"), found.find("transform")
    assert intrinsic is not None
    assert turn is not None
    x, y, z = (float(turn.attrib[f"r{row}3"]) for row in (1, 2, 3))
    return _view_deg(float(intrinsic.attrib["focalLengthU"]) / 64, 1920), np.array([x, -y, -z])


def _view_deg(focal_px: float, longer_px: int) -> float:
    return float(np.degrees(2 * np.arctan(longer_px / 2 / focal_px)))


def _film(name: str, film: Filmed, table: Table, hits: Hits) -> None:
    """A film by its own lens, and by one that is a guess."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "session.json"
        _tracked(film, path)
        session = load_session(path)
        fitting = load_results(session, path).fitting(session)
        view = session.view.camera
        guessed = session.changed(
            {"camera": Camera.guess(view.width, view.height), "lens_source": "guess"}
        )
        with open_video_of(session, path) as video:
            lines, by_guess = (upright_lines(one, video) for one in (session, guessed))
        _row(name, film.up, session, fitting, lines, table, hits)
        _row(f"{name}, lens guessed", film.up, guessed, {}, by_guess, table, hits)


def _tracked(film: Filmed, path: Path) -> None:
    """Draft with nothing known of up, accept and track, in a session at this path."""
    order = FilmOrder(box=film.box, frame=40, frames=film.frames, field_of_view=film.view_deg)
    asked = FilmToDraft(film.path, order=order)
    with opened_film(asked) as video:
        session = begun_session(asked, video, path)
        found = drafted(
            session, video, 40, film.box, film.frames, proportions=True, report=lambda _: None
        )
        who = WhoIsDrafted(40, film.box)
        session = with_draft_kept(session, video, path, who, film.frames, found)
    frames = [draft.frame for draft in session.subject.drafts]
    keys = {*frames[::EVERY], frames[-1]}
    accepted = [
        softened(d.model_copy(update={"drafted": False}), True)
        for d in session.subject.drafts
        if d.frame in keys
    ]
    rest = [draft for draft in session.subject.drafts if draft.frame not in keys]
    save_session(with_drafts(with_keyframes(session, accepted), rest), path)
    run_quietly("track", str(path))


def _row(
    name: str,
    truth: Array,
    session: Session,
    fitting: dict[Span, SegmentResult],
    lines: UprightLines | None,
    table: Table,
    hits: Hits,
) -> None:
    truth = truth / np.linalg.norm(truth)
    seen = None if lines is None else lines.evidence
    motions = motions_of(session, fitting)
    found = estimated_up(session, motions, seen)
    evidence = (*(() if seen is None else (seen,)), *evidence_of_motion(session, motions))
    said: dict[str, UnsureUp] = {one.source: one for one in evidence}
    said |= {} if found is None else {"all": found}
    for way, one in said.items():
        if way == "feet" and name in NOT_LEVEL:
            continue
        hits.inside[way].append(_angle(one.up, truth) < 2 * one.sigma_rad)
        if one.sigma_along(AHEAD) < SHOWN_RAD:
            hits.shares[way].append(_share(one, truth))
    apart = () if found is None else [one.evidence.source for one in found.apart]
    cells = [_cell(said[way], truth) if way in said else "" for way in WAYS]
    table.row(name, float(np.degrees(np.arcsin(truth[2]))), *cells, ", ".join(apart))


def _cell(one: UnsureUp, truth: Array) -> str:
    return f"{np.degrees(_angle(one.up, truth)):.1f} ± {min(off_deg(one.sigma_rad), 99)}"


def _share(one: UnsureUp, truth: Array) -> float:
    return float((one.up - truth)[2] / one.sigma_along(AHEAD))


def _angle(a: Sequence[float] | Array, b: Array) -> float:
    return float(np.arccos(np.clip(np.asarray(a) @ b, -1.0, 1.0)))
