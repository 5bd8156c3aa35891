"""Describe a body, pose it at two frames, track it: `python examples/2_a_body_of_your_own.py`.

It is one leg of a walking figure; `keypose open out/leg/session.json` then shows it on the page.
"""

from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from keypose import tracker

CLIP = Path(__file__).parents[1] / "sample_videos" / "person" / "person.mp4"
LEG = Path("out", "leg", "session.json")
thigh = {"kind": "cylinder", "start_m": 0, "end_m": 0.43, "radius_m": 0.073}  # down along y
shin = {"kind": "cylinder", "start_m": 0, "end_m": 0.46, "radius_m": 0.047}
free, hinge = ["tx", "ty", "tz", "rx", "ry", "rz"], ["rx"]
parts = [
    {"name": "thigh", "shape": thigh, "tracked": free},
    {"name": "shin", "parent": "thigh", "joint_m": [0, 0.43, 0], "shape": shin, "tracked": hinge},
]
before = {"thigh": (0.771, -0.128, 0.618, 0.084), "shin": (0.991, 0.136, 0, 0)}  # w, x, y, z
after = {"thigh": (0.849, 0.042, 0.524, -0.048), "shin": (0.932, 0.362, 0, 0)}
key24 = tracker.Keyframe(frame=24, time_s=0.8, root_m=(0.34, -0.08, 5.4), rotations_wxyz=before)
key48 = tracker.Keyframe(frame=48, time_s=1.6, root_m=(-0.11, -0.08, 5.2), rotations_wxyz=after)
session = tracker.Session.begin(
    video={"path": str(CLIP), "fingerprint": "", "frame_count": 73, "width": 640, "height": 360},
    camera=tracker.Camera(width=640, height=360, fx=900, fy=900, cx=319.5, cy=179.5),
    body=tracker.Body(name="leg", parts=parts),
    keyframes=(key24, key48),
)
with tracker.open_video_of(session, LEG) as video:
    *_, done = tracker.track_session(session, video)
LEG.parent.mkdir(parents=True, exist_ok=True)
tracker.save_session(tracker.save_result(session, LEG, done.result), LEG)

motion = done.result.trajectory
bends = Rotation.from_matrix(motion.Rs_parent_part[:, 1]).magnitude()  # of the shin, radians
for frame in range(24, 49, 4):
    print(f"frame {frame}: the knee is bent by {np.degrees(bends[frame - 24]):.0f}°")
