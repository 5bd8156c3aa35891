"""A real person who raises both arms in the picture's plane: joints marked by eye at three frames.

The camera is guessed and the body sized on the marks, so that only pixels can be compared.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from bench.keeping import ROOT, data_folder, digest, place_for
from bench.marked import FITTED_FROM, Person, _marks
from bench.posing import Marked, fit
from keypose.tracker.body.body import Body, preset
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.camera import Camera

MARKS = Path(__file__).with_name("arms_marks.json")
VIDEO = "arms_576x576.mp4"
SIDE, DEPTH_M = 576, 3.9


def load_arms() -> Person:
    """Sized and posed on the marks, which takes a minute or two, or as kept of it."""
    folder = data_folder("arms")
    camera = Camera.guess(SIDE, SIDE)
    frames = json.loads(MARKS.read_text(encoding="utf-8"))["frames"]
    marked = [
        Marked(int(frame), {name: (float(u), float(v)) for name, (u, v) in joints.items()}, {})
        for frame, joints in frames.items()
    ]
    sources = [ROOT / "tracker" / name for name in FITTED_FROM]
    key = digest(ROOT / "bench" / "posing.py", *sources, MARKS)
    place = place_for("posed-arms", key, ".npz")
    if not place.is_file():
        posed = fit(preset("adult_female"), camera, marked, DEPTH_M)
        found = [posed.poses[m.frame] for m in marked]
        Rs, ps = [p.Rs_parent_part for p in found], [p.p_camera_root for p in found]
        np.savez(
            place, body=posed.skeleton.body.model_dump_json(), Rs=np.stack(Rs), ps=np.stack(ps)
        )
    with np.load(place) as kept:
        skeleton = Skeleton.of(Body.model_validate_json(str(kept["body"])))
        pairs = zip(marked, kept["Rs"], kept["ps"], strict=True)
        poses = {m.frame: Pose(R, p) for m, R, p in pairs}
    return Person(folder / VIDEO, camera, skeleton, poses, _marks(skeleton.body, marked))
