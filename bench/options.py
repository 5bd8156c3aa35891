"""What may be asked of a group of benchmarks besides its name."""

from __future__ import annotations

import argparse
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

from keypose.tracker.session.settings import TrackSettings

JITTERS = 8
SEEDS = 3


@dataclass(frozen=True)
class Options:
    """Only `real`, `effort` and `install` ask for them.

    rows: names of rows; all that are not held out where there are none.  held_out: these instead.
    jitters: how often the keyframes are disturbed.  ways: more settings to compare, by name.
    out: where figures are written as they come.  clips, strategies: of `effort`, all where there
    are none.  seeds: how many persons.  in_page: two keyframes are made
    again in a browser.  pythons: interpreters to install for; this one where there are none.
    """

    rows: tuple[str, ...] = ()
    held_out: bool = False
    jitters: int = JITTERS
    ways: Mapping[str, TrackSettings] = field(default_factory=dict)
    out: Path = Path("out/bench/real.json")
    clips: tuple[str, ...] = ()
    strategies: tuple[str, ...] = ()
    seeds: int = SEEDS
    in_page: bool = True
    pythons: tuple[str, ...] = ()


def add_options(parser: argparse.ArgumentParser) -> None:
    """The options on a command line."""
    given = parser.add_argument_group("of the group real")
    given.add_argument("--rows", type=_names, default=(), metavar="ROW,ROW", help="only these rows")
    given.add_argument("--held-out", action="store_true", help="the rows kept from development")
    given.add_argument("--jitters", type=_count, default=JITTERS, metavar="N")
    given.add_argument("--quick", action="store_true", help="two jitters")
    given.add_argument(
        "--way", action="append", type=way, default=[], metavar="NAME=JSON", dest="ways",
        help='more settings to compare, such as static=\'{"static_camera": true}\'',
    )  # fmt: skip
    given.add_argument("--out", type=Path, default=Options.out, help="figures as they come")
    given = parser.add_argument_group("of the group effort")
    given.add_argument("--clips", type=_names, default=(), metavar="CLIP,CLIP", help="only these")
    given.add_argument(
        "--strategies", type=_names, default=(), metavar="NAME,NAME", help="only these ways to work"
    )
    given.add_argument("--seeds", type=_count, default=SEEDS, metavar="N", help="so many persons")
    given.add_argument("--no-page", action="store_true", help="nothing again in a browser")
    given = parser.add_argument_group("of the group install")
    given.add_argument("--python", action="append", default=[], metavar="PATH", dest="pythons")


def options_of(given: argparse.Namespace) -> Options:
    """What was asked for."""
    jitters = min(given.jitters, 2) if given.quick else given.jitters
    return Options(
        given.rows, given.held_out, jitters, dict(given.ways), given.out,
        given.clips, given.strategies, given.seeds, not given.no_page,
        tuple(given.pythons),
    )  # fmt: skip


def way(text: str) -> tuple[str, TrackSettings]:
    """A name and settings; a setting that there is not is an error, not a wish."""
    name, _, given = text.partition("=")
    try:
        values = json.loads(given)
        settings = TrackSettings.model_validate(values)
    except ValueError as error:
        raise argparse.ArgumentTypeError(f"{text}: {error}") from None
    if unknown := sorted(set(values) - set(TrackSettings.model_fields)):
        raise argparse.ArgumentTypeError(f"there is no setting {', '.join(unknown)}")
    return name, settings


def _names(text: str) -> tuple[str, ...]:
    return tuple(text.split(","))


def _count(text: str) -> int:
    count = int(text)
    if count < 1:
        raise argparse.ArgumentTypeError("at least 1")
    return count
