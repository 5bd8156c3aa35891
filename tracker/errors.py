"""The exceptions of the package. Every message is one sentence: what was wrong, what to do.

KeyposeError
├── VideoError      a video that cannot be read, or a frame that is not there
├── CameraError     a camera that cannot project
├── BodyError       a body that is not a tree of solid parts
├── SessionError    a session file, its keyframes or its video do not fit together
├── KeypointError   keypoints that cannot be found, or a file of them that cannot be used
├── SurfaceError    observed surfaces, or one step of them, that cannot be used
├── ReductionError  a motion that cannot be reduced to keyframes
└── FormatError     a reference or motion file that cannot be read or written
    └── ChoiceError  one that can be read once it is said which of several is meant
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pydantic import ValidationError
    from pydantic_core import ErrorDetails


LONGEST_WORDS = 600
LONGEST_BEGINNING = 400
"""Characters of a sentence, and of its beginning where it quotes a name that is longer."""


class KeyposeError(Exception):
    """Something the user can fix; the message is one sentence and needs no traceback."""

    def __init__(self, words: str = "") -> None:
        super().__init__(_short(words))


class VideoError(KeyposeError):
    """The video, or one frame of it, cannot be read."""


class CameraError(KeyposeError):
    """The camera's numbers do not describe a camera."""


class BodyError(KeyposeError):
    """The body's parts do not form a tree of solid shapes."""


class SessionError(KeyposeError):
    """A session cannot be read, or its parts do not fit together."""


class KeypointError(KeyposeError):
    """Keypoints cannot be found, or their network or file cannot be used."""


class SurfaceError(KeyposeError):
    """Observed surfaces, or the surface of one step, cannot be used."""


class ReductionError(KeyposeError):
    """A motion cannot be reduced to keyframes as asked."""


class FormatError(KeyposeError):
    """A file in an outside format cannot be read or written."""


class ChoiceError(FormatError):
    """A file that can be read once it is said which of several is meant.

    option: what is to be chosen, as the command line calls it.  choices: what there is.
    """

    def __init__(self, words: str, option: str, choices: Sequence[str]) -> None:
        super().__init__(words)
        self.option, self.choices = option, tuple(choices)


# --- sentences


_OBJECT = "should be an object, with a name for every value"
"""What is said where pydantic would name a class of this program."""


ID_PATTERN = "^[a-z0-9_-]{1,40}$"
"""Of what names a view or a body in a session."""

_WORDS: Mapping[str, str] = {
    "too_short": "should hold at least {min_length}, not {actual_length}",
    "too_long": "should hold at most {max_length}, not {actual_length}",
}
"""What is said where pydantic would speak of its own types, by its name of the problem."""

_PATTERNS: Mapping[str, str] = {
    ID_PATTERN: "should be 1 to 40 lower-case letters, digits, hyphens and underscores",
}


def one_sentence(error: ValidationError) -> str:
    """The first problem as a sentence that names the field and says what is allowed."""
    first = error.errors(include_url=False)[0]
    place = ".".join(str(step) for step in first["loc"])
    text = _plain(first).removeprefix("Value error, ").rstrip(".")
    for step in first["loc"]:
        text = text.removeprefix(f"{step}: ")
    text = text[:1].lower() + text[1:]
    more = error.error_count() - 1
    rest = f" (and {more} more)" if more else ""
    return f"{place}: {text}{rest}." if place else f"{text[:1].upper()}{text[1:]}{rest}."


def _plain(problem: ErrorDetails) -> str:
    """A problem in pydantic's words, or in those of this program where they name its insides."""
    facts = problem.get("ctx", {})
    if "class_name" in facts:
        return _OBJECT
    if facts.get("pattern") in _PATTERNS:
        return _PATTERNS[facts["pattern"]]
    if problem["type"] in _WORDS:
        return _WORDS[problem["type"]].format(**facts)
    return problem["msg"]


def listed(names: Sequence[str]) -> str:
    """ "head", "head and neck", "head, neck and chest"."""
    return " and ".join(filter(None, (", ".join(names[:-1]), *names[-1:])))


def _short(words: str) -> str:
    """A sentence that quotes a name of thousands of characters, without its middle."""
    line = " ".join(words.splitlines())
    end = LONGEST_WORDS - LONGEST_BEGINNING
    return line if len(line) <= LONGEST_WORDS else f"{line[:LONGEST_BEGINNING]} … {line[-end:]}"


MOST_LISTED = 8
"""Numbers, or runs of them, that are called by their names."""


def numbers_listed(numbers: Set[int], step: int = 1) -> str:
    """ "3, 7–9 and 12"; of many runs the first, and how many numbers more there are.

    step: between two that follow one another.
    """
    firsts = [number for number in sorted(numbers) if number - step not in numbers]
    lasts = [number for number in sorted(numbers) if number + step not in numbers]
    runs = list(zip(firsts, lasts, strict=True))
    names = [f"{first}" if first == last else f"{first}–{last}" for first, last in runs]
    left = sum((last - first) // step + 1 for first, last in runs[MOST_LISTED:])
    return listed([*names[:MOST_LISTED], *([f"{left} more"] if left else [])])


def readable(name: str) -> str:
    """A part's name in a sentence: "left hand"."""
    return name.replace("_", " ")
