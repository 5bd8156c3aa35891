"""Match the joint names of a file with places on a body.

A convention counts as a whole: LeftShoulder is the collar bone in one program and the upper arm in
another. The convention that knows most of a file's joints is taken; the body's own names come
first, then the rigs that Keypose writes, then `conventions.json`:

    title    programs that use these names
    joints   plain name to place; `{}` is the side. A place is a part (its joint), a landmark, a
             point of the face, `left_ball` (where the toes begin), or the middle of two
    instead  the same, for places that no other name claims: a foot is the ankle where none is named

Case, blanks, punctuation, what stands before a colon, and words that most names of a file begin or
end with, as in `Bip01 L Thigh` or `left_leg_joint`, do not matter. A side is a word or a letter at
either end. Of the body's own names the order of the words does not matter either: paw_front_L is
left_front_paw. What a name does not say is never guessed: a person says it, name by name.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import resources
from pathlib import Path

import numpy as np
from pydantic import BaseModel, ConfigDict

from keypose.tracker.body.body import Body, Point
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError, listed
from keypose.tracker.files import TooLarge, read_regular
from keypose.tracker.formats.conventions import end_site
from keypose.tracker.formats.marker_sets import places_of
from keypose.tracker.formats.rigs import OWN, RIGS
from keypose.tracker.formats.rigs.table import SIDES, Place, Row, table_of
from keypose.tracker.keypoints.layouts import snake
from keypose.tracker.solver.posed import BodyPoint

LARGEST_NAMES_BYTES = 2**20
MOST_LISTED = 24
"""Names in a sentence."""

_LETTERS = {"left": "left", "l": "left", "right": "right", "r": "right"}
_GLUED = {"left": "left", "right": "right", "左": "left", "右": "right"}
_SYNONYMS = {"l": "left", "r": "right", "fore": "front", "back": "hind", "rear": "hind"}
END = "end"
"""`part.end` is where a part ends: at the joint of its one child, or at the end of its shape."""
COMMON = 0.6
"""Share of a file's names that begin or end with a word which then says nothing."""
_BALL: Place = {"{side}_toe": 0.66, "{side}_heel": 0.22, "{side}_foot": 0.12}
"""Where the toes begin, by weights."""


@dataclass(frozen=True)
class Matched:
    """Which of a file's names are known.

    convention: whose names they are.
    known: their index among the file's names, the name given to their place, and the place.
    left_out: names without a place.
    """

    convention: str
    known: tuple[tuple[int, str, BodyPoint], ...]
    left_out: tuple[str, ...]

    @property
    def count(self) -> int:
        """How much is known: not by the ends of parts, which every convention has alike."""
        return sum(not ours.endswith("_end") for _, ours, _ in self.known)

    @property
    def indices(self) -> list[int]:
        return [index for index, _, _ in self.known]

    @property
    def places(self) -> list[BodyPoint]:
        return [place for _, _, place in self.known]


def matched(
    skeleton: Skeleton,
    names: Sequence[str],
    file: str,
    ours_of_theirs: Mapping[str, str] | None = None,
) -> Matched:
    """Match a file's names with places; a place that several names claim goes to the first of them.

    ours_of_theirs: our names by the file's; where it is given, nothing else counts.
    """
    if ours_of_theirs is not None:
        return _match_given(skeleton, names, file, ours_of_theirs)
    words = [_words(name) for name in names]
    bare = _without_common(words)
    spellings = [words] if bare == words else [words, bare]
    conventions = (_own_names(skeleton), *_rigs(skeleton.body), *_conventions(skeleton.body))
    candidates = [
        _match(convention, names, spelt) for convention in conventions for spelt in spellings
    ]
    return max(candidates, key=lambda m: m.count)  # the first of those alike


def match_also(
    skeleton: Skeleton, automatic: Matched, names: Sequence[str], file: str, also: Mapping[str, str]
) -> Matched:
    """Match names as a person said, by places such as left_shin, left_shin.end or head.nose. These
    count before what was matched, and free a name or place they take.

    FormatError names what the file or the body does not have.
    """
    missing = [name for name in also if name not in names]
    if missing:
        raise FormatError(
            f"{file} has no keypoint {missing[0]!r}; it has {listed(list(names[:MOST_LISTED]))}."
        )
    asked = {names.index(n): (ours, _given_place(skeleton, ours)) for n, ours in also.items()}
    taken = {place for _, place in asked.values()}
    kept = (entry for entry in automatic.known if entry[0] not in asked and entry[2] not in taken)
    every = sorted([*kept, *((i, *match) for i, match in asked.items())])
    indices = {index for index, _, _ in every}
    left_out = tuple(name for i, name in enumerate(names) if i not in indices)
    return Matched(f"{automatic.convention}, --map", tuple(every), left_out)


def load_names(path: Path) -> dict[str, str]:
    """A file {"their name": "our joint"}; FormatError in one sentence when it is not one."""
    try:
        names = json.loads(read_regular(path, LARGEST_NAMES_BYTES))
    except TooLarge:
        raise FormatError(f"{path.name} is too large for a list of names.") from None
    except OSError as error:
        raise FormatError(f"{str(path)!r} cannot be read: {error.strerror or error}.") from None
    except (ValueError, RecursionError):
        raise FormatError(f"{path.name} is not JSON.") from None
    if not isinstance(names, dict) or not all(isinstance(v, str) for v in names.values()):
        raise FormatError(f'{path.name} should read {{"their name": "our joint", …}}.')
    return names


def plain(name: str) -> str:
    """Reduce a name to what matters."""
    return "".join(_words(name))


def _words(name: str) -> list[str]:
    return snake(re.split(r"[:/|]", name)[-1]).split("_")


def _without_common(names: Sequence[Sequence[str]]) -> list[list[str]]:
    """Drop the words that most names begin or end with, but for sides."""
    bare = [list(name) for name in names]
    for end in (0, -1):
        while True:
            words = Counter(name[end] for name in bare if len(name) > 1)
            word, count = max(words.items(), key=lambda item: item[1], default=("", 0))
            if count < max(COMMON * len(bare), 3) or word in _LETTERS:
                break
            for name in bare:
                if len(name) > 1 and name[end] == word:
                    name.pop(end)
    return bare


# --- conventions


@dataclass(frozen=True)
class _Convention:
    """What names mean: by spelling the name of the place and the place; `instead` as in the file.

    A spelling is a plain name, or a side, a blank and the rest.
    """

    title: str
    places: Mapping[str, tuple[str, BodyPoint]]
    instead: Mapping[str, tuple[str, BodyPoint]] = field(default_factory=dict)


def _match(convention: _Convention, names: Sequence[str], words: Sequence[list[str]]) -> Matched:
    match_of_index: dict[int, tuple[str, BodyPoint]] = {}
    spellings = [_spellings(name_words) for name_words in words]
    for places in (convention.places, convention.instead):
        taken = {place for _, place in match_of_index.values()}
        for index, spelt in enumerate(spellings):
            match = next((places[spelling] for spelling in spelt if spelling in places), None)
            if match is not None and match[1] not in taken:
                taken.add(match[1])
                match_of_index[index] = match
    matches = tuple((index, *match_of_index[index]) for index in sorted(match_of_index))
    left_out = tuple(name for index, name in enumerate(names) if index not in match_of_index)
    return Matched(convention.title, matches, left_out)


def _spellings(words: Sequence[str]) -> tuple[str, ...]:
    """Under which a name may stand in a convention, the surest first."""
    joined, ordered = "".join(words), " " + " ".join(sorted(_SYNONYMS.get(w, w) for w in words))
    for at, rest in ((0, words[1:]), (-1, words[:-1])):
        if rest and words[at] in _LETTERS:
            return joined, f"{_LETTERS[words[at]]} {''.join(rest)}", ordered
    for mark, side in _GLUED.items():
        if joined.startswith(mark) or joined.endswith(mark):
            return joined, f"{side} {joined.removeprefix(mark).removesuffix(mark)}", ordered
    return joined, ordered


@cache
def _rows() -> tuple[_Row, ...]:
    """The file of conventions, validated."""
    text = (resources.files("keypose.tracker.formats") / "conventions.json").read_text("utf-8")
    return tuple(_Row.model_validate(row) for row in json.loads(text))


class _Row(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")

    title: str
    joints: dict[str, str]
    instead: dict[str, str] = {}


def _conventions(body: Body) -> list[_Convention]:
    return [
        _Convention(row.title, _both_sides(body, row.joints), _both_sides(body, row.instead))
        for row in _rows()
    ]


def _both_sides(body: Body, joints: Mapping[str, str]) -> dict[str, tuple[str, BodyPoint]]:
    """List by spelling the places that the body has; `l` and `r` may be glued to a name as well."""
    place_of_spelling: dict[str, tuple[str, BodyPoint]] = {}
    for name, where in joints.items():
        for side in SIDES if "{}" in name else ("",):
            ours = where.replace("{side}", side)
            place = _place(body, ours)
            if place is None:
                continue
            for spelt in (f"{side} {name.replace('{}', '')}", name.replace("{}", side[:1])):
                place_of_spelling.setdefault(spelt.strip(), (ours, place))
    return place_of_spelling


def _rigs(body: Body) -> list[_Convention]:
    """The rigs that are written, read backwards: bones that begin at one place of one part."""
    conventions = []
    for rig in RIGS:
        if rig == OWN:
            continue
        table = table_of(rig)
        bones = ((plain(row.name), _bone(body, row)) for row in table.rows())
        places = {name: place for name, place in bones if place is not None}
        conventions.append(_Convention(table.title, places))
    return conventions


def _bone(body: Body, row: Row) -> tuple[str, BodyPoint] | None:
    """The part's joint, the landmark or the ball of the foot at which a bone begins; None for
    bones between these, which other makers have elsewhere."""
    joint = next((part for part in row.part if part in body.names), None)
    for weights in row.at or (() if joint is None else ({joint: 1.0},)):
        if len(weights) == 1:
            ours = next(iter(weights))
        elif set(weights.values()) == set(_BALL.values()):
            ours = f"{row.side}_ball"
        else:
            continue
        place = _place(body, ours)
        if place is not None:
            return ours, place
    return None


def _match_given(
    skeleton: Skeleton, names: Sequence[str], file: str, ours_of_theirs: Mapping[str, str]
) -> Matched:
    missing = sorted(set(ours_of_theirs) - set(names))
    if missing:
        raise FormatError(f"{file} has no joint {missing[0]!r}, which the list of names speaks of.")
    places = dict(
        zip(
            ours_of_theirs,
            places_of(skeleton, list(ours_of_theirs.values()), "The list"),
            strict=True,
        )
    )
    matches = tuple((i, ours_of_theirs[n], places[n]) for i, n in enumerate(names) if n in places)
    return Matched("given", matches, tuple(name for name in names if name not in places))


def _own_names(skeleton: Skeleton) -> _Convention:
    """The body's parts and landmarks, and the ends of parts as our own BVH files have them."""
    table: dict[str, tuple[str, BodyPoint]] = {}
    for i, part in enumerate(skeleton.body.parts):
        table[plain(part.name)] = (part.name, ((i, (0.0, 0.0, 0.0)),))
        if not (skeleton.parents == i).any():
            table[plain(f"{part.name}_end")] = (f"{part.name}_end", ((i, end_site(part)),))
    for i, part in enumerate(skeleton.body.parts):
        for name, p in part.landmarks.items():
            table.setdefault(plain(name), (name, ((i, p),)))
            table.setdefault(plain(f"{part.name}.{name}"), (name, ((i, p),)))
    places = {ours: (ours, place) for ours, place in table.values()}
    ordered = {ours: _spellings(_words(ours))[-1] for ours in places}
    counts = Counter(ordered.values())
    in_any_order = {spelt: places[ours] for ours, spelt in ordered.items() if counts[spelt] == 1}
    return _Convention("the body's own", in_any_order | table)


def _given_place(skeleton: Skeleton, ours: str) -> BodyPoint:
    """A part's joint, its end, or a landmark; FormatError lists the parts where it is none."""
    part, _, point = ours.partition(".")
    body = skeleton.body
    if part in body.names and point == END:
        return ((body.index(part), _end(skeleton, body.index(part))),)
    if part in body.names and point in body.parts[body.index(part)].landmarks:
        return ((body.index(part), body.parts[body.index(part)].landmarks[point]),)
    place = None if point else _place(body, part)
    if place is None:
        raise FormatError(
            f"The body has no place {ours!r}: say PART, PART.end or a landmark; its parts are "
            f"{listed(body.names)}."
        )
    return place


def _end(skeleton: Skeleton, part: int) -> Point:
    children = np.flatnonzero(skeleton.parents == part)
    if len(children) != 1:
        return end_site(skeleton.body.parts[part])
    x, y, z = skeleton.joints[children[0]]
    return float(x), float(y), float(z)


def _place(body: Body, ours: str) -> BodyPoint | None:
    """A part's joint, a landmark, a point of the face or of a foot, or the middle of parts; None
    where the body lacks it."""
    points: list[tuple[int, Point]] = []
    for name in ours.split("+"):
        point = _point(body, name)
        if point is None:
            return None
        points.append(point)
    return tuple(points)


def _point(body: Body, name: str) -> tuple[int, Point] | None:
    if name in body.names:
        return body.index(name), (0.0, 0.0, 0.0)
    for i, part in enumerate(body.parts):
        if name in part.landmarks:
            return i, part.landmarks[name]
    side, _, kind = name.partition("_")
    if kind == "ball":
        return _weighted(body, {one.replace("{side}", side): w for one, w in _BALL.items()})
    if "head" in body.names:
        i = body.index("head")
        face = body.parts[i].shape.face_points()
        if name in face:
            return i, face[name]
    return None


def _weighted(body: Body, weights: Place) -> tuple[int, Point] | None:
    """The point between places of one part; None where they are of several, or one is missing."""
    points = [point for name in weights if (point := _point(body, name)) is not None]
    if len(points) < len(weights) or len({part for part, _ in points}) > 1:
        return None
    x, y, z = np.average([p for _, p in points], axis=0, weights=list(weights.values()))
    return points[0][0], (float(x), float(y), float(z))
