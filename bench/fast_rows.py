"""What people wait for, one row at a time: run by `bench/fast.py`, once in each revision.

It takes nothing but the tracker's own interface, so that revisions of before run it as well, and
what both work on comes from the one that measures: body, camera, poses and the film's path. Each
line of the standard input names a row; the answer is a line of JSON: seconds of processors, by the
clock, and how often the unit was done.
"""

from __future__ import annotations

import json
import pickle
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.keypoints.detect import Seed, detect
from keypose.tracker.keypoints.detectors import open_detector
from keypose.tracker.keypoints.model_files import find_model
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.tracking.cues.drafted import DraftedKeypoints
from keypose.tracker.tracking.cues.sources import DetectedKeypoints
from keypose.tracker.tracking.pool import run
from keypose.tracker.tracking.tracker import Tracker
from keypose.tracker.video import Video

LOOKS = 12
NUDGED_M = 0.003
UNLIKE_M = 1e-8
CUES = {"keypoints": ("brightness", "keypoints", "silhouette"), "brightness": ("brightness",)}


class Film:
    """A film between keyframes, with what a draft saw of it."""

    def __init__(self, known: SimpleNamespace) -> None:
        self.video = Video.open(known.video)
        self.camera = Camera.model_validate_json(known.camera)
        self.skeleton = Skeleton.of(Body.model_validate_json(known.body))
        self.poses = {n: Pose(np.array(R), np.array(p)) for n, (R, p) in known.poses.items()}
        self.box, self.span = known.box, (min(self.poses), max(self.poses))
        self.seed = Seed.of_box(self.span[0], self.box, self.camera.width, self.camera.height)
        self.network = find_model("thunder")
        self.turns = 0
        self._keypoints: Any = None
        self._tracker: Any = None

    def look(self, last: int) -> Any:
        detector = open_detector(self.network)
        return detect(self.video.frame, (self.span[0], last), [self.seed], detector)

    def tracker(self) -> Tracker:
        """With prepared pictures, and the keypoints of a draft."""
        if self._tracker is None:
            self._keypoints = self.look(self.span[1])
            looked = DetectedKeypoints(self.video, self.camera, model=self.network)
            source = DraftedKeypoints(self._keypoints, looked, self.camera)
            self._tracker = Tracker(
                self.video, self.camera, self.skeleton, self.poses, keypoints=source
            )
            self._tracker.loader(self.span).load(*self.span)
        return self._tracker

    def prepare(self) -> int:
        """The pictures of the film."""
        fresh = Tracker(self.video, self.camera, self.skeleton, self.poses)
        whole = not hasattr(fresh, "pictures")  # a revision that knows no windows
        for a, b in fresh.spans:
            fresh.loader((a, b)).load(a, b) if whole else fresh.pictures((a, b))
        return self.span[1] - self.span[0]


def renewed(film: Film) -> Tracker:
    """A tracker that has followed nothing yet, on the pictures that are there: its keyframes differ
    by next to nothing from those of before, so that nothing that is kept of these serves it."""
    tracker = film.tracker()
    film.turns += 1
    aside = film.turns * UNLIKE_M
    poses = {
        n: Pose(p.Rs_parent_part.copy(), p.p_camera_root + aside) for n, p in film.poses.items()
    }
    source = tracker.keypoint_source(TrackSettings(cues=CUES["keypoints"]))
    return tracker.renewed(film.skeleton, poses, keypoints=source)


def track(film: Film, cues: str) -> int:
    for _ in run(renewed(film), TrackSettings(cues=CUES[cues])):
        pass
    return film.span[1] - film.span[0]


def live(film: Film, quality: str) -> int:
    """Both segments beside a keyframe that is moved, the others as they were."""
    tracker, rng = film.tracker(), np.random.default_rng(0)
    frame = sorted(film.poses)[1]
    pose = film.poses[frame]
    place = pose.p_camera_root + NUDGED_M * rng.normal(size=3)
    tracker.move_keyframe(frame, Pose(pose.Rs_parent_part.copy(), place))
    for _ in run(tracker, TrackSettings(cues=CUES["keypoints"], quality=quality), [0, 1]):
        pass
    return 1


def apart(name: str) -> dict[str, float]:
    """What preparing a film's pictures takes in a process of its own: memory that has been touched
    before costs nothing, and a person's first pictures never lie in such. Its frames have been
    examined for damage and decoded, as after a draft: that is no row of pictures."""
    command = [sys.executable, "-P", *sys.argv[:2], name]
    answer: dict[str, float] = json.loads(subprocess.check_output(command, text=True))
    return answer


def measured(work: Callable[[], int]) -> dict[str, float]:
    """Seconds that work takes, its units, and the most memory that this process has held."""
    wall, cpu = time.perf_counter(), time.process_time()
    units = work()
    spent = {"cpu": time.process_time() - cpu, "wall": time.perf_counter() - wall}
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {**spent, "units": units, "peak_mb": peak}


def rows(films: dict[str, Film]) -> dict[str, Callable[[], int]]:
    """Every row: does its work and says how many units that was."""
    found: dict[str, Callable[[], int]] = {}
    for name, film in films.items():
        found[f"networks, {name}"] = lambda film=film: film.look(film.span[0] + LOOKS) and LOOKS
        found[f"pictures, {name}"] = film.prepare
        for cues in CUES:
            found[f"track by {cues}, {name}"] = lambda film=film, cues=cues: track(film, cues)
        for quality in ("preview", "full"):
            if len(film.poses) > 2:
                found[f"live {quality}, {name}"] = lambda film=film, q=quality: live(film, q)
    return found


def main() -> None:
    known = pickle.loads(Path(sys.argv[1]).read_bytes())
    if len(sys.argv) > 2:
        film = Film(SimpleNamespace(**known[sys.argv[2]]))
        for _ in film.video.sound_frames(film.span[0], film.span[1] + 1):
            pass
        print(json.dumps(measured(film.prepare)))
        return
    table = rows({name: Film(SimpleNamespace(**each)) for name, each in known.items()})
    print(json.dumps(list(table)), flush=True)
    for line in sys.stdin:
        row, _, film = line.strip().partition(", ")
        spent = apart(film) if row == "pictures" else measured(table[line.strip()])
        print(json.dumps(spent), flush=True)


if __name__ == "__main__":
    main()
