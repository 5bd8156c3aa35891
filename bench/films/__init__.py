"""Two films of one motion beside one, and beside what others triangulate from the same two."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from bench.films.between_keyframes import keyed
from bench.films.clocks import cameras_and_clocks
from bench.films.in_browser import counted
from bench.films.in_rendered import rendered
from bench.films.man import man_on_the_beam
from bench.films.others import triangulated_by_others
from bench.films.without_a_hand import unattended
from bench.table import Report


def films(report: Report) -> None:
    """The figures of one film and of two."""
    rendered(report)
    with TemporaryDirectory() as folder:
        man = man_on_the_beam(Path(folder))
        cameras_and_clocks(report, man)
        keyed(report, man)
        alone = unattended(report, man, Path(folder))
        triangulated_by_others(report, man, alone, Path(folder))
        counted(report, man, Path(folder))
