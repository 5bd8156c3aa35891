"""`python -m bench [GROUP …]`: measure, print, and write benchmarks.json.

Figures stand beside what is expected of them; one that falls short is said to, and nothing more
happens. Groups whose material is not here say so and the others go on.
"""

from __future__ import annotations

import argparse
import importlib
import json
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from bench.keeping import ROOT, Absent, digest
from bench.table import Report

GROUPS = (
    "rendered",
    "cube",
    "real",
    "keypoints",
    "fit_here",
    "fit_sizes",
    "cost",
    "page",
    "long",
    "surface",
    "space",
    "standing",
    "up",
    "markers",
    "angles",
    "camera",
    "films",
    "bodies",
    "panned",
    "mask",
    "evidence",
    "drafts",
    "effort",
    "rigs",
    "install",
    "fuzz",
    "gains",
    "fast",
)
ASKED_FOR = ("gains", "fast")
"""Measured only where it is asked for: the one takes hours, the other checks out a revision."""
OUT = Path("benchmarks.json")


def main() -> None:
    parser = argparse.ArgumentParser(prog="python -m bench", description=__doc__)
    parser.add_argument("groups", nargs="*", metavar="GROUP", help=", ".join(GROUPS))
    parser.add_argument("--beside", metavar="REV", help="the revision that fast is measured beside")
    given = parser.parse_args()
    asked = given.groups or [name for name in GROUPS if name not in ASKED_FOR]
    more = {"fast": {} if given.beside is None else {"beside": given.beside}}
    for name in asked:
        if name not in GROUPS:
            parser.error(f"there is no group {name!r}; the groups are {', '.join(GROUPS)}")
    kept = _earlier()
    for name in asked:
        kept[name] = _measured(name, more.get(name, {}))
        OUT.write_text(json.dumps(kept, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
    print()
    for name in asked:
        short, seconds = kept[name]["short"], kept[name]["seconds"]
        print(f"{name}: {short or 'no'} figures short, {seconds:.0f} s")


def _measured(name: str, more: dict[str, str]) -> dict[str, Any]:
    """Run one group."""
    report, began = Report(name), time.perf_counter()
    try:
        getattr(importlib.import_module(f"bench.{name}"), name)(report, **more)
    except Absent as absent:
        report.note(f"left out: {absent} is not here")
    seconds = time.perf_counter() - began
    when = datetime.now(UTC).isoformat(timespec="seconds")
    tracker = digest(ROOT / "tracker")
    return {"when": when, "tracker": tracker, "seconds": round(seconds, 1), **report.as_json()}


def _earlier() -> dict[str, Any]:
    """Groups of an earlier run that are not measured now; each tells when it was measured."""
    try:
        kept = json.loads(OUT.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return {name: kept[name] for name in GROUPS if name in kept}


if __name__ == "__main__":
    main()
