"""The names that other programs give to joints, and where on our body they are.

A convention is taken as a whole: the same name is another joint in another one, as LeftShoulder is
the collar bone's joint here and the upper arm's there. The one that knows most of a file's names
counts; the body's own names come first. Case, blanks, dots, dashes, underscores and what stands
before a colon, as in `mixamorig:`, do not matter. Of the body's own names the order of the words
does not matter either, nor whether a side is a word or a letter: paw_front_L is left_front_paw.
What a name does not say is never guessed: a person says it, name by name.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from keypose.tracker.body.body import Body, Point
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import FormatError, listed
from keypose.tracker.files import TooLarge, read_regular
from keypose.tracker.formats.end_sites import end_site
from keypose.tracker.formats.marker_names import places_of
from keypose.tracker.keypoints.layouts import snake
from keypose.tracker.solver.body_points import BodyPoint

LARGEST_NAMES_BYTES = 2**20
MOST_LISTED = 24
"""Names in a sentence."""

_SHOULDERS = "left_upper_arm+right_upper_arm"
_HIPS = "left_thigh+right_thigh"
_SIDES = {"left": ("left", "l"), "right": ("right", "r")}
_WORDS = {"l": "left", "r": "right", "fore": "front", "back": "hind", "rear": "hind"}
END = "end"
"""`part.end` is where a part ends: at the joint of its one child, or at the end of its shape."""


def _both(**joints: str) -> dict[str, str]:
    """Names of both sides: `{}` in a name stands for the side as the convention writes it."""
    return {
        name.format(side): f"{ours}_{part}"
        for name, part in joints.items()
        for ours, sides in _SIDES.items()
        for side in sides
    }


_FACE = _both(**{"{}eye": "eye", "{}ear": "ear"}) | {"nose": "nose"}
_LIMBS = _both(
    **{
        "{}shoulder": "upper_arm", "{}elbow": "forearm", "{}wrist": "hand",
        "{}hip": "thigh", "{}knee": "shin", "{}ankle": "foot",
        "{}bigtoe": "toe", "{}smalltoe": "toe", "{}toe": "toe", "{}foot": "toe", "{}heel": "heel",
    }
)  # fmt: skip

CONVENTIONS: dict[str, dict[str, str]] = {
    "COCO, OpenPose": _LIMBS
    | _FACE
    | {"neck": _SHOULDERS, "midhip": _HIPS, "hip": _HIPS}
    | {"upperneck": "head", "headtop": "head_top"}
    | _both(**{"{}footindex": "toe"}),
    "SMPL": _both(
        **{
            "{}collar": "clavicle", "{}shoulder": "upper_arm", "{}elbow": "forearm",
            "{}wrist": "hand", "{}hip": "thigh", "{}knee": "shin", "{}ankle": "foot",
        }
    )
    | {"pelvis": "waist", "spine1": "chest", "neck": "neck", "head": "head"},
    "BVH with elbows and knees": _LIMBS
    | {"neck": "neck", "head": "head", "headend": "head_top"}
    | _both(**{"{}ankle": "foot", "{}toeend": "toe"}),
    "Mixamo, MotionBuilder": _both(
        **{
            "{}upleg": "thigh", "{}leg": "shin", "{}foot": "foot", "{}toebase": "toe",
            "{}arm": "upper_arm", "{}forearm": "forearm", "{}hand": "hand",
        }
    )
    | {"neck": "neck", "head": "head", "headtopend": "head_top"},
    "CMU": _both(
        **{
            "{}femur": "thigh", "{}tibia": "shin", "{}foot": "foot", "{}toes": "toe",
            "{}humerus": "upper_arm", "{}radius": "forearm", "{}wrist": "hand",
        }
    )
    | {"lowerneck": "neck", "head": "head"},
    "Poser, DAZ": _both(
        **{
            "{}thigh": "thigh", "{}shin": "shin", "{}foot": "foot",
            "{}shldr": "upper_arm", "{}forearm": "forearm", "{}hand": "hand",
            "{}footend": "toe",
        }
    )
    | {"neck": "neck", "head": "head"},
    "OpenSim, Plug-in Gait": _both(
        **{
            "{}sho": "upper_arm", "{}acromium": "upper_arm", "{}sjc": "upper_arm",
            "{}elb": "forearm", "{}ejc": "forearm", "{}wjc": "hand",
            "{}hjc": "thigh", "{}kne": "shin", "{}kjc": "shin", "{}ank": "foot", "{}ajc": "foot",
            "{}toe": "toe", "{}hee": "heel", "{}heel": "heel",
        }
    )
    | {"c7": "neck", "topofhead": "head_top", "vsacral": _HIPS},
}  # fmt: skip
"""By convention, plain names with a part, a landmark, a place of the face, or the middle of two."""


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
    def indices(self) -> list[int]:
        return [index for index, _, _ in self.known]

    @property
    def places(self) -> list[BodyPoint]:
        return [place for _, _, place in self.known]


def matched(
    skeleton: Skeleton, names: Sequence[str], file: str, given: Mapping[str, str] | None = None
) -> Matched:
    """The joints of a file by their names; `given` names ours by theirs, and then alone counts.

    A place that several names claim goes to the first of them.
    """
    if given is not None:
        return _match_given(skeleton, names, file, given)
    tables = {"the body's own": _own_names(skeleton)}
    for convention, table in CONVENTIONS.items():
        tables[convention] = {
            name: (ours, place)
            for name, ours in table.items()
            if (place := _place(skeleton.body, ours)) is not None
        }
    found = {c: _match(c, names, table) for c, table in tables.items()}
    return max(found.values(), key=lambda m: len(m.known))  # the first of those alike


def match_also(
    skeleton: Skeleton, known: Matched, names: Sequence[str], file: str, also: Mapping[str, str]
) -> Matched:
    """With what a person said of some names, by places such as left_shin, left_shin.end or
    head.nose: it counts before what was matched, and a name or place it takes is free of others.

    FormatError names what the file or the body does not have.
    """
    missing = [name for name in also if name not in names]
    if missing:
        raise FormatError(
            f"{file} has no keypoint {missing[0]!r}; it has {listed(list(names[:MOST_LISTED]))}."
        )
    asked = {names.index(n): (ours, _given_place(skeleton, ours)) for n, ours in also.items()}
    taken = {place for _, place in asked.values()}
    kept = (one for one in known.known if one[0] not in asked and one[2] not in taken)
    every = sorted([*kept, *((i, *match) for i, match in asked.items())])
    indices = {index for index, _, _ in every}
    left_out = tuple(name for i, name in enumerate(names) if i not in indices)
    return Matched(f"{known.convention}, --map", tuple(every), left_out)


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
    """A name without what does not matter."""
    return re.sub(r"[\W_]", "", name.rsplit(":", 1)[-1]).lower()


def _match(
    convention: str, names: Sequence[str], table: Mapping[str, tuple[str, BodyPoint]]
) -> Matched:
    known, left_out, taken = [], [], set()
    for index, name in enumerate(names):
        ours, place = table.get(plain(name)) or table.get(_words(name)) or ("", ())
        if not place or place in taken:
            left_out.append(name)
            continue
        taken.add(place)
        known.append((index, ours, place))
    return Matched(convention, tuple(known), tuple(left_out))


def _match_given(
    skeleton: Skeleton, names: Sequence[str], file: str, given: Mapping[str, str]
) -> Matched:
    missing = sorted(set(given) - set(names))
    if missing:
        raise FormatError(f"{file} has no joint {missing[0]!r}, which the list of names speaks of.")
    places = dict(zip(given, places_of(skeleton, list(given.values()), "The list"), strict=True))
    known = tuple((i, given[n], places[n]) for i, n in enumerate(names) if n in places)
    return Matched("given", known, tuple(name for name in names if name not in places))


def _own_names(skeleton: Skeleton) -> dict[str, tuple[str, BodyPoint]]:
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
    return _in_any_order([ours for ours, _ in table.values()], table) | table


def _in_any_order(
    names: Sequence[str], table: Mapping[str, tuple[str, BodyPoint]]
) -> dict[str, tuple[str, BodyPoint]]:
    """By their words in order of the alphabet, but for those that several names have."""
    places = {name: table[plain(name)] for name in names}
    words = [_words(name) for name in places]
    return {w: p for w, p in zip(words, places.values(), strict=True) if words.count(w) == 1}


def _words(name: str) -> str:
    """The words of a name in order of the alphabet, with a blank before: no plain name has one."""
    parts = snake(name.rsplit(":", 1)[-1]).split("_")
    return " " + " ".join(sorted(_WORDS.get(part, part) for part in parts))


def _given_place(skeleton: Skeleton, ours: str) -> BodyPoint:
    """A part's joint, its end, or a landmark; FormatError lists the parts where it is none."""
    part, _, what = ours.partition(".")
    body = skeleton.body
    if part in body.names and what == END:
        return ((body.index(part), _end(skeleton, body.index(part))),)
    if part in body.names and what in body.parts[body.index(part)].landmarks:
        return ((body.index(part), body.parts[body.index(part)].landmarks[what]),)
    place = None if what else _place(body, part)
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
    """A part's joint, a landmark, a place of the face, or the middle of parts; None without it."""
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
    if "head" in body.names:
        i = body.index("head")
        face = body.parts[i].shape.face_points()
        if name in face:
            return i, face[name]
    return None
