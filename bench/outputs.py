"""`python -m bench.outputs FILE`: digests of all that the commands write, one per line.

Run it before and after a change that should change nothing, and compare the two files: every
sample, both methods, three qualities, observed surfaces, all exports and pictures.
"""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from keypose.app.export.motion_formats import FORMATS

ROOT = Path(__file__).parents[1]
OUT = Path("out/outputs")
FILMS = ("balance", "box", "person")
SURFACES = ("arms",)
METHODS = ("keypose", "paper")
QUALITIES = ("preview", "full")
PEOPLE = ("balance", "person")
OF_A_PERSON = ("mot", "amass")
"""Formats that refuse any other body."""
REFERENCES = {"box": "truth.npz", "person": "truth.npz"}
LATE = ("report.html",)
"""What names the time it was written at."""


def main() -> None:
    shutil.rmtree(ROOT / OUT, ignore_errors=True)
    with Path(sys.argv[1]).open("w", encoding="utf-8") as lines:
        for line in _all():
            print(line, file=lines, flush=True)


def _all() -> Iterator[str]:
    for sample in FILMS:
        given = f"sample_videos/{sample}/session.json"
        for method in METHODS:
            for quality in QUALITIES:
                out = OUT / f"{sample}-{method}-{quality}"
                how = ["--method", method, "--quality", quality]
                yield _run(out, "track", given, "--out", str(out), *how)
                yield from _exported(out, sample)
        out = OUT / f"{sample}-templates"
        yield _run(out, "track", given, "--out", str(out), "--initial", "templates")
        yield from _exported(out, sample)
    for sample in SURFACES:
        given = f"sample_videos/{sample}/session.json"
        for weights in ("both", "none"):
            for distance in ("plane", "point"):
                out = OUT / f"{sample}-{weights}-{distance}"
                how = ["--weights", weights, "--distance", distance]
                yield _run(out, "fit", "--session", given, "--out", str(out), *how)
                yield from _exported(out, sample)


def _exported(out: Path, sample: str) -> Iterator[str]:
    """What the other commands make of a tracked session, and the digests of all files."""
    session = str(out / "session.json")
    formats = [name for name in FORMATS if sample in PEOPLE or name not in OF_A_PERSON]
    yield _run(out, "export", session, "--format", ",".join(formats), "--out", str(out))
    for view in ("all", "main", "orbit:30,20"):
        name = out / f"{view.split(':')[0]}.png"
        given = ["--frame", "3", "--view", view, "--out", str(name)]
        yield _run(out, "shot", session, *given)
    yield _run(out, "sheet", session, "--out", str(out / "sheet.png"))
    if sample in REFERENCES:
        truth = f"sample_videos/{sample}/{REFERENCES[sample]}"
        yield _run(out, "evaluate", session, "--reference", truth, "--json")
    for path in sorted((ROOT / out).rglob("*")):
        if path.is_file() and path.name not in LATE and not path.name.startswith("."):
            digest = hashlib.sha256(path.read_bytes()).hexdigest()[:16]
            yield f"{path.relative_to(ROOT / OUT)} {digest}"


def _run(out: Path, *words: str) -> str:
    """A command's exit code and a digest of what it prints."""
    command = [sys.executable, "-m", "keypose.app", *words]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True)
    if ran.returncode not in (0, 1):
        raise RuntimeError(f"{' '.join(words)}: {ran.stderr.decode()}")
    digest = hashlib.sha256(ran.stdout).hexdigest()[:16]
    return f"{out.name} {words[0]}: {ran.returncode} {digest}"


if __name__ == "__main__":
    main()
