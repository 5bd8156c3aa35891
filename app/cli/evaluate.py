"""`keypose evaluate`: the tracked motion against a reference."""

from __future__ import annotations

import argparse
from pathlib import Path

from keypose.app.cli.arguments import note
from keypose.app.cli.bodies import about_one
from keypose.app.cli.json_output import json_value, print_json
from keypose.tracker.apart import reading_apart
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.evaluate import Evaluation, Measure, Spread, evaluate, evaluate_joints
from keypose.tracker.formats.reference import load_reference
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.fingerprints import open_ends
from keypose.tracker.storage.outdated import outdated_words, tracked_keyframes
from keypose.tracker.storage.tracks import load_trajectory

_KINDS = {
    "pixels": ("in the picture", "px", 1.0),
    "distance_m": ("in space", "cm", 100.0),
    "depth_m": ("along the camera axis", "cm", 100.0),
    "angle_deg": ("joint angles", "°", 1.0),
}
"""Each measure with its title, its unit on screen and that unit's factor."""


def run(arguments: argparse.Namespace) -> int:
    session = about_one(load_session(arguments.session), arguments)
    evaluation = _evaluation(session, arguments.session, arguments.reference)
    if arguments.json:
        print_json({"reference": str(arguments.reference), **json_value(evaluation)}, indent=2)
        return 0
    print(f"{arguments.reference.name}: {len(evaluation.frames)} frames between keyframes")
    for line in _lines(evaluation):
        print(line)
    return 0


def _evaluation(session: Session, session_path: Path, reference_path: Path) -> Evaluation:
    with reading_apart(load_reference) as read:
        skeleton, camera = Skeleton.of(session.subject.body), session.view.camera
        reference = read(reference_path, skeleton)
    estimate = load_trajectory(session, session_path)
    note(outdated_words(session, estimate))
    keyed = tracked_keyframes(session), open_ends(session), session.camera_path
    if isinstance(reference, Trajectory):
        return evaluate(skeleton, camera, estimate, reference, *keyed)
    return evaluate_joints(skeleton, camera, estimate, reference, *keyed)


def _lines(evaluation: Evaluation) -> list[str]:
    lines = []
    for kind, (title, unit, factor) in _KINDS.items():
        ours = getattr(evaluation.estimate, kind)
        linear = getattr(evaluation.interpolation, kind)
        if ours is not None:
            lines += ["", *_table(f"{title}, {unit}", factor, ours, linear)]
    return lines


def _table(title: str, factor: float, ours: Measure, linear: Measure) -> list[str]:
    width = max(len(title), *(len(name) for name in ours.each), len("all"))
    columns = ("mean", "median", "95 %")
    head = "".join(f"{column:>9}" for column in columns)
    groups = f"{'':{width}}{'tracked':>27}  {'interpolated':>27}"
    rows = [("all", ours.overall, linear.overall)]
    rows += [(name, spread, linear.each[name]) for name, spread in ours.each.items()]
    lines = [groups, f"{title:{width}}{head}  {head}"]
    for name, a, b in rows:
        lines.append(f"{name:{width}}{_figures(a, factor)}  {_figures(b, factor)}")
    return lines


def _figures(spread: Spread, factor: float) -> str:
    if not spread.count:
        return f"{'–':>9}" * 3
    return "".join(f"{value * factor:9.2f}" for value in (spread.mean, spread.median, spread.p95))
