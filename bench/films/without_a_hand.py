"""Drafts accepted and tracked without a hand, by one film and by two."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bench.films.man import BESIDE, FIRST, Man, about_hips, quietly
from bench.keeping import DATA
from bench.table import Report
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import joined
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.session import Session
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.results import load_results


@dataclass(frozen=True, eq=False)
class Unattended:
    """A session made without a hand, and its joints (N, 12, 3) from a frame on, in the first
    camera's frame."""

    session: Session
    first_frame: int
    joints: Array


def unattended(report: Report, man: Man, folder: Path) -> Unattended:
    """What one film gives, and what two do, which is handed back."""
    table = report.table(
        "drafts accepted and tracked without a hand, lenses and cameras unknown", "about hips mm"
    )
    for count in (1, 2):
        made = _made(folder / f"alone-{count}", count)
        truth = man.truth[made.first_frame :][: len(made.joints)]
        off = np.linalg.norm(about_hips(made.joints) - about_hips(truth), axis=-1)
        table.row(f"{count} film{'s' * (count > 1)}", 1000 * float(off.mean()))
    return made


def _made(out: Path, count: int) -> Unattended:
    films = [DATA / "several" / f"single_cam0{number}.mp4" for number in (FIRST, BESIDE)]
    quietly("draft", str(films[0]), "--accept", "--out", str(out))
    if count > 1:
        quietly("add-film", str(out), str(films[1]))
    quietly("track", str(out))
    return joints_of_session(out / "session.json")


def joints_of_session(path: Path) -> Unattended:
    """The tracked motion of a saved session."""
    session = load_session(path)
    fitting = load_results(session, path).fitting(session)
    motion = joined([fitting[span].trajectory for span in sorted(fitting)])
    skeleton = Skeleton.of(session.subject.body)
    _, parts, points = points_on_body(skeleton.body, JOINTS)
    joints = BodyPoints.single(skeleton, parts, points).at(motion.transforms(skeleton))
    return Unattended(session, motion.first_frame, joints)
