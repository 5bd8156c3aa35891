#!/usr/bin/env bash
# ezc3d 1.7.2 writes 65,536 frames without a word and reads 65,535 of them back: the header's last
# frame and POINT:FRAMES stop there. Seen: shapes (4, 2, 65536) written, (4, 2, 65535) read.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet ezc3d==1.7.2 numpy==2.4.6
cd "$folder"
venv/bin/python - <<'PYTHON'
import ezc3d
import numpy as np

read = {}
for frames in (65_535, 65_536):
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [50.0]
    file["parameters"]["POINT"]["LABELS"]["value"] = ["a", "b"]
    file["data"]["points"] = np.ones((4, 2, frames))
    file.write("a.c3d")
    read[frames] = ezc3d.c3d("a.c3d")["data"]["points"].shape[2]
print("ezc3d", ezc3d.__version__, read)
assert read == {65_535: 65_535, 65_536: 65_535}, read
PYTHON
