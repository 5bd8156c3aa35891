"""What parts, joints and landmarks are called in files."""

from __future__ import annotations

from collections.abc import Sequence

from keypose.tracker.body.pose import joint_names
from keypose.tracker.body.skeleton import Skeleton


def column_names(skeleton: Skeleton) -> tuple[str, ...]:
    """Names as of `joint_names`; a landmark whose name is not the only one carries its part's."""
    names = joint_names(skeleton)
    owners = [part.name for part in skeleton.body.parts for _ in part.landmarks]
    landmarks = names[skeleton.part_count :]
    pairs = zip(owners, landmarks, strict=True)
    marks = (f"{owner}.{name}" if names.count(name) > 1 else name for owner, name in pairs)
    return (*skeleton.body.names, *marks)


def single_words(names: Sequence[str]) -> tuple[str, ...]:
    """The names without blanks and braces, which end a name in some formats; still different."""
    words: list[str] = []
    for name in names:
        word = "".join("_" if c.isspace() or c in "{}" else c for c in name)
        while word in words:
            word += "_"
        words.append(word)
    return tuple(words)
