#!/usr/bin/env bash
# OpenCV 5.0.0's threads, idle between calls, spin: a program that calls it for small pictures in
# turn with work of its own pays for a second processor and is done no sooner. The spinning calls
# sched_yield, so that it shows as system time. OPENCV_FOR_THREADS_NUM=1 or cv2.setNumThreads(1)
# ends it. Needs two processors.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet opencv-python-headless==5.0.0.93 numpy==2.4.6
cd "$folder"
cat > work.py <<'PYTHON'
import time

import cv2
import numpy as np

picture = np.random.default_rng(0).integers(0, 256, (360, 640, 3), dtype=np.uint8)
began = time.perf_counter()
before = time.process_time()
for _ in range(1000):
    grey = cv2.pyrDown(cv2.cvtColor(picture, cv2.COLOR_RGB2GRAY))
    sum(range(60_000))
clock = time.perf_counter() - began
print(clock, (time.process_time() - before) / clock)
PYTHON
read -r clock many < <(OPENCV_FOR_THREADS_NUM=2 venv/bin/python work.py)
read -r alone one < <(OPENCV_FOR_THREADS_NUM=1 venv/bin/python work.py)
echo "two threads: $clock s, $many of a processor; one thread: $alone s, $one"
venv/bin/python - "$clock" "$many" "$alone" "$one" <<'PYTHON'
import sys

clock, many, alone, one = map(float, sys.argv[1:])
assert many > 1.15 * one, "idle threads no longer spin"
assert clock > 0.9 * alone, "two threads are quicker now"
PYTHON
