"""`python -m tests.film_or_surfaces [ROOT]`: the lines that ask whether it is a film or surfaces.

What a body is compared with answers for itself (tracker/session/evidence.py), so that another kind
of it is one more class. Every line listed here, outside the rooms that answer, would have to be
thought of again.
"""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[1]
ROOMS = ("app", "tracker")
ANSWERING = ("tracker/surface/", "tracker/session/evidence.py", "tracker/storage/evidence/")
"""Where surfaces are at home, and where evidence answers."""

QUESTION = re.compile(
    r"\bsurface is (?:not )?None"
    r"|\b(?:if|elif|and|or|not|while|assert) \(?[\w.]+\.surface\b(?! is|\.|\()"
    r"|isinstance\([^()]*(?:SurfaceVideo|SurfaceEvidence|FilmEvidence)"
    r"|\bis_of_surfaces\b"
    r"|(?<!self\.view )(?<!self\.name )[!=]= (?:CONTAINER|\"surfaces\"|\"film\")"
    r"|\b(?:if|not) surfaces\b"
    r"|\bevidence\.kind (?:[!=]=|in|not in)"
)


def questions(root: Path = ROOT) -> Iterator[str]:
    """Every such line, with its place; the page's view of another film is called "film", too."""
    for room in ROOMS:
        for file in sorted((root / room).rglob("*.py")):
            place = file.relative_to(root).as_posix()
            if place.startswith(ANSWERING):
                continue
            for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), start=1):
                if QUESTION.search(line):
                    yield f"{place}:{number}: {line.strip()}"


if __name__ == "__main__":
    found = list(questions(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT))
    print(*found, len(found), sep="\n")
