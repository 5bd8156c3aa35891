#!/usr/bin/env bash
# OpenCV 5.0.0's Python calcOpticalFlowPyrLK does not take what its own buildOpticalFlowPyramid
# makes, as the C++ function does: a pyramid that is kept for one picture cannot be used for the
# next, and is built again at every call, forward and back.
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
one = cv2.GaussianBlur(rng.integers(0, 256, (240, 320), dtype=np.uint8), (0, 0), 3)
two = np.roll(one, 2, axis=1)
at = np.array([[[100, 100]], [[150, 120]]], np.float32)
levels, first = cv2.buildOpticalFlowPyramid(one, (21, 21), 3)
_, second = cv2.buildOpticalFlowPyramid(two, (21, 21), 3)
moved = cv2.calcOpticalFlowPyrLK(one, two, at, None)[0] - at
print("OpenCV", cv2.__version__, "pictures:", moved.reshape(-1, 2).round(2).tolist())
print("pyramids:", levels, "levels,", len(first), "arrays")
assert np.allclose(moved.reshape(-1, 2), (2, 0), atol=0.05), moved
try:
    cv2.calcOpticalFlowPyrLK(first, second, at, None)
except cv2.error as error:
    print("refused:", str(error).strip().splitlines()[-2])
else:
    raise SystemExit("taken: this has changed")
PYTHON
