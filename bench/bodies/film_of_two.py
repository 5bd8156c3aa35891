"""The film in which a man on a beam passes before and behind a second person.

She was drawn into the film of the man alone, so what is true of him there is true here. She stays
where she stands, mostly before him in the picture, yet as small as somebody two metres behind him:
by their poses she never hides him.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal, TypeAlias

import numpy as np

from bench.bodies.promises import Promise
from bench.films.man import FIRST, FPS, Man, about_hips, man_on_the_beam, quietly
from bench.keeping import DATA
from bench.table import Report
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.operations.occlusion import ignored_regions
from keypose.tracker.operations.track import track_session
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.sidecars import keypoints_of_session
from keypose.tracker.tracking.pool import TrackFinished
from keypose.tracker.tracking.result import SegmentResult
from keypose.tracker.video import Video

FILM: Final = "multi_cam03.mp4"
ALONE: Final = "single_cam03.mp4"
BOXES: Final = ("490,390,800,1330", "170,480,390,1050")
"""Around him and her at the first frame, in which they are apart."""
HER_BODY: Final = "adult_female"
LOOKS: Final = range(36, 99, 2)
"""Every second frame in which he passes her: in a film of 60 frames a second the network looks at
every second one."""
RIGHT_SHARE: Final = 0.1
"""Of a person's height in the picture, by which joints are off in the median in a right look."""
LEAST_RIGHT: Final = 26
KEYFRAMES: Final = ((36, 96), (20, 50, 80), (0, 30, 60, 90))

Look: TypeAlias = Literal["right", "other", "wrong", "unseen"]


@dataclass(frozen=True, eq=False)
class Posed:
    """A drafted film whose man has his true keyframes."""

    film: Path
    folder: Path

    def session(self, man: Man, frames: Sequence[int]) -> Session:
        keyframes = tuple(
            Keyframe.of(man.skeleton, man.motion.pose(frame), frame, frame / FPS)
            for frame in frames
        )
        fields = {
            "camera": man.views[FIRST].camera,
            "body": man.skeleton.body,
            "keyframes": keyframes,
        }
        return load_session(self.folder / "session.json").changed(fields)

    def tracked(self, man: Man, frames: Sequence[int]) -> list[SegmentResult]:
        session = self.session(man, frames)
        keypoints = keypoints_of_session(session, self.folder)
        with Video.open(self.film) as video:
            for event in track_session(session, video, keypoints=keypoints):
                if isinstance(event, TrackFinished):
                    return list(event.result.segments)
        raise AssertionError("tracking ended without saying so")


def film_of_two(report: Report, folder: Path) -> list[Promise]:
    """Who is looked at, and what becomes of right keyframes."""
    man = man_on_the_beam(folder, (FIRST,))
    drafted = _drafted(man, folder / "two")
    return [*_looks(report, man, drafted.folder), *_keyframes(report, man, drafted)]


def _drafted(man: Man, out: Path) -> Posed:
    film, camera = DATA / "several" / FILM, man.views[FIRST].camera
    angle = math.degrees(2 * math.atan(camera.height / 2 / camera.fy))
    boxes = [word for box in BOXES for word in ("--box", box)]
    lens = ("--field-of-view", f"{angle:.3f}")
    people = (*boxes, "--frame", "0", "--body", HER_BODY)
    quietly("draft", str(film), *people, *lens, "--accept", "--out", str(out))
    return Posed(film, out)


def _looks(report: Report, man: Man, folder: Path) -> list[Promise]:
    report.note(
        f"looks: every second frame from {LOOKS[0]} to {LOOKS[-1]}, in which he passes her; right: "
        f"the median of {len(JOINTS)} joints is off by at most {RIGHT_SHARE:g} of the person's "
        "height; on the other: not right, and nearer to the joints of the other"
    )
    session = load_session(folder / "session.json")
    him, her = (_joints(session.about(body.id), folder) for body in session.bodies)
    true = man.views[FIRST].camera.project(man.joints)
    standing = np.broadcast_to(her[0], her.shape)
    of_him = [judged_look(him[n], true[n], standing[n]) for n in LOOKS]
    of_her = [judged_look(her[n], standing[n], true[n]) for n in LOOKS]
    table = report.table("looks while he passes her", "right", "on other", "wrong", "unseen")
    for name, looks in (("of him", of_him), ("of her", of_her)):
        table.row(name, *(looks.count(kind) for kind in ("right", "other", "wrong", "unseen")))
    on_other = of_him.count("other") + of_her.count("other")
    return [
        Promise.at_least(f"of {len(LOOKS)} looks on him", of_him.count("right"), LEAST_RIGHT),
        Promise.at_most("looks on the other", on_other, 0),
    ]


def _joints(session: Session, folder: Path) -> Array:
    """(N, 12, 2) the joints of the body that is posed, as a draft saw them."""
    keypoints: Keypoints | None = keypoints_of_session(session, folder)
    assert keypoints is not None
    return keypoints.uv[:, [keypoints.names.index(name) for name in JOINTS]]


def judged_look(uv: Array, own_uv: Array, other_uv: Array) -> Look:
    """On whom a look lies. uv (J, 2): where it has joints, NaN where nobody was seen; own_uv,
    other_uv: where those of the person are who is meant, and those of the other."""
    if np.isnan(uv).any():
        return "unseen"
    off, off_other = (
        float(np.median(np.linalg.norm(uv - joints, axis=-1))) for joints in (own_uv, other_uv)
    )
    if off <= RIGHT_SHARE * float(np.ptp(own_uv[:, 1])):
        return "right"
    return "other" if off_other < off else "wrong"


def _keyframes(report: Report, man: Man, drafted: Posed) -> list[Promise]:
    columns = ("two mm", "alone mm", "ratio", "she before", "blamed", "lost")
    report.note("she before: frames in which the program takes her to hide him, by their poses")
    table = report.table("him between right keyframes, joints about the hips", *columns)
    alone = Posed(DATA / "several" / ALONE, man.folders[FIRST])
    blamed = 0
    for frames in KEYFRAMES:
        segments = drafted.tracked(man, frames)
        off, off_alone = (_off_mm(man, each) for each in (segments, alone.tracked(man, frames)))
        regions = ignored_regions(drafted.session(man, frames))
        before = len({region.first_frame for region in regions})
        wrong = sum(each.verdict.cause == "keyframe_off_keypoints" for each in segments)
        lost = sum(each.kind == "lost" for each in segments)
        blamed += sum(is_blamed(each) for each in segments)
        name = "keyframes " + ", ".join(map(str, frames))
        table.row(name, off, off_alone, off / off_alone, before, wrong, lost)
    return [Promise.at_most("lost, or a right keyframe blamed", blamed, 0)]


def is_blamed(segment: SegmentResult) -> bool:
    """Whether a segment between right keyframes is called lost, or one of them wrong."""
    return segment.kind == "lost" or segment.verdict.cause == "keyframe_off_keypoints"


def _off_mm(man: Man, segments: Sequence[SegmentResult]) -> float:
    off = []
    for segment in segments:
        joints = man.places.at(segment.trajectory.transforms(man.skeleton))
        truth = man.truth[segment.first : segment.last + 1]
        away = np.linalg.norm(about_hips(joints) - about_hips(truth), axis=-1)
        off.append(away[1:-1].mean(axis=1))
    return 1000 * float(np.concatenate(off).mean())
