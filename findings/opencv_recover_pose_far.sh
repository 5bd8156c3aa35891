#!/usr/bin/env bash
# OpenCV 5.0.0's recoverPose, given an exact essential matrix and exact points, returns the camera
# turned round by 180° where all points lie beyond 50 baselines: none of its four candidates then
# has a point, and the first one is returned with 0 inliers. `distanceThresh` in the call mends it,
# and the call then returns five values in place of four.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet opencv-python-headless==5.0.0.93 numpy==2.4.6
cd "$folder"
venv/bin/python - <<'PYTHON'
import cv2
import numpy as np

rng = np.random.default_rng(0)
K = np.array([[800, 0, 320], [0, 800, 240], [0, 0, 1.0]])
X = rng.uniform((-3, -2, 6), (3, 2, 9), (200, 3))
R = cv2.Rodrigues(np.array([0, 0.01, 0]))[0]


def seen(points):
    uv = points @ K.T
    return uv[:, :2] / uv[:, 2:]


def recovered(baseline, **more):
    t = np.array([baseline, 0, 0])
    across = np.array([[0, 0, 0], [0, 0, -baseline], [0, baseline, 0]])
    found = cv2.recoverPose(across @ R, seen(X), seen(X @ R.T + t), K, **more)
    off = np.degrees(np.linalg.norm(cv2.Rodrigues(found[1] @ R.T)[0]))
    return len(found), found[0], round(float(off), 6)


near, far, told = recovered(0.3), recovered(0.05), recovered(0.05, distanceThresh=1e4)
print("OpenCV", cv2.__version__, "(values, inliers of 200, degrees off)")
print("20-30 baselines:", near)
print("120-180 baselines:", far, "with distanceThresh:", told)
assert near == (4, 200, 0.0), near
assert far == (4, 0, 180.0), far
assert told == (5, 200, 0.0), told
PYTHON
