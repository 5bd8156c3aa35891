"""Track every session in a folder, read what came of each: `python examples/4_batch.py`.

It copies two samples to `out/recordings`; `batch-report.html` there shows what this leaves out.
"""

import json
import shutil
import subprocess
import sys
from pathlib import Path

SAMPLES = Path(__file__).parents[1] / "sample_videos"
KEYPOSE = Path(sys.executable).with_name("keypose")
RECORDINGS = Path("out", "recordings")

for name in ("box", "person"):
    shutil.copytree(SAMPLES / name, RECORDINGS / name, dirs_exist_ok=True)

batch = [KEYPOSE, "batch", RECORDINGS, "--quality", "preview", "--export", "bvh", "--overwrite"]
events = subprocess.run([*batch, "--json"], stdout=subprocess.PIPE, check=True).stdout
summary = json.loads(events.splitlines()[-1])  # one JSON object a line, the summary last

for session in summary["sessions"]:
    print(f"{Path(session['session']).parent.name}: {session['state']}")
    for segment in session["segments"]:
        print(f"  frames {segment['first']}–{segment['last']}: {segment['words']}")
    for file in session["exported"]:
        print(f"  {Path(file).relative_to(RECORDINGS.absolute())}")
