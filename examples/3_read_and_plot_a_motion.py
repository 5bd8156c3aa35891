"""Track a filmed man and plot his knees: `python examples/3_read_and_plot_a_motion.py`.

It needs matplotlib (`pip install matplotlib`) and leaves the motion and `knees.png` in `out/knees`.
"""

import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

SAMPLE = Path(__file__).parents[1] / "sample_videos" / "balance" / "session.json"
KEYPOSE = Path(sys.executable).with_name("keypose")
OUT = Path("out", "knees")


def keypose(*arguments: object) -> None:
    subprocess.run([KEYPOSE, *map(str, arguments)], check=True)


keypose("track", SAMPLE, "--quality", "preview", "--out", OUT, "--overwrite")
keypose("export", OUT / "session.json", "--format", "csv", "--out", OUT, "--overwrite")

angles = np.genfromtxt(OUT / "angles.csv", delimiter=",", names=True)
frames = np.genfromtxt(OUT / "frames.csv", delimiter=",", names=True, dtype=None)
keyed = frames["pose"] == "keyframe"

figure, axes = plt.subplots(figsize=(8, 4), layout="constrained")
for side in ("left", "right"):
    bend = angles[f"{side}_knee_flexion_deg"]
    (line,) = axes.plot(angles["time_s"], bend, label=f"{side} knee")
    axes.plot(angles["time_s"][keyed], bend[keyed], "o", color=line.get_color())
axes.set(xlabel="time, s", ylabel="bend, degrees", title="Dots are keyframes")
axes.legend()
figure.savefig(OUT / "knees.png", dpi=120)
print(f"The {side} knee bends by up to {bend.max():.0f}°: {OUT / 'knees.png'}")
