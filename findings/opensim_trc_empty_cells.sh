#!/usr/bin/env bash
# OpenSim 4.6 refuses a TRC row that ends in empty cells, though it reads the same gap as `nan`, and
# an empty marker anywhere but at the row's end. Seen: one file of three is refused.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install --quiet opensim==4.6
cd "$folder"
venv/bin/python - <<'PYTHON'
import opensim

opensim.Logger.setLevelString("Off")
HEAD = (
    "PathFileType\t4\t(X/Y/Z)\ta.trc\n"
    "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\tOrigNumFrames\n"
    "30\t30\t2\t2\tmm\t30\t1\t2\n"
    "Frame#\tTime\tA\t\t\tB\t\t\n"
    "\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n"
    "\n"
    "1\t0.0\t1\t2\t3\t4\t5\t6\n"
)
ROWS = {
    "last marker empty": "2\t0.1\t1\t2\t3\t\t\t\n",
    "first marker empty": "2\t0.1\t\t\t\t4\t5\t6\n",
    "last marker nan": "2\t0.1\t1\t2\t3\tnan\tnan\tnan\n",
}
found = {}
for name, row in ROWS.items():
    with open("a.trc", "w") as file:
        file.write(HEAD + row)
    try:
        found[name] = opensim.TimeSeriesTableVec3("a.trc").getNumRows()
    except Exception:
        found[name] = "refused"
print(opensim.GetVersion(), found)
assert found == {"last marker empty": "refused", "first marker empty": 2, "last marker nan": 2}, found
PYTHON
