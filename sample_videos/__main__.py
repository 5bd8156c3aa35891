"""Make all samples anew, from what is in the project:  python -m keypose.sample_videos

Each by its own script, in a process of its own; the filmed clips stay as they are. Some minutes.
"""

from __future__ import annotations

import subprocess
import sys

SCRIPTS = ("make_samples", "make_arms", "make_balance", "make_walk", "make_pictures")
"""In this order: the last one shows what the others have made."""


def main() -> None:
    for script in SCRIPTS:
        print(script, flush=True)
        subprocess.run([sys.executable, "-m", f"keypose.sample_videos.{script}"], check=True)


if __name__ == "__main__":
    main()
