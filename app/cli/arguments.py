"""What the commands' arguments have in common."""

from __future__ import annotations

import argparse
import os
import re
import sys
import textwrap
from collections.abc import Callable, Container, Iterable, Mapping
from pathlib import Path
from typing import Any, Final, TypeAlias, TypeVar

from keypose.app.export.motion_formats import MotionFormat, formats_of
from keypose.app.orders.film import FILM_ORDERS, require_whom
from keypose.app.orders.order import Option, options_of, require_one_of_each_group
from keypose.app.orders.values import Choice, Misread, Switch, Value, Whole
from keypose.tracker.errors import FormatError, listed

Subcommands: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"

OrderT = TypeVar("OrderT")

COMMANDS: Final[Mapping[str, tuple[str, str]]] = {
    "open": (
        "program",
        "Open a video, a folder of meshes or a session in the "
        "browser: pose keyframes over the picture, track, correct, export",
    ),
    "run": ("motion", "Turn films into motion without a hand: draft, track, stand, export"),
    "draft": ("motion", "Draft a pose for every frame, of the people in boxes or the one found"),
    "add-film": ("motion", "Add another film of the same motion: its clock and camera are found"),
    "add-body": ("motion", "Add a body to a session, or remove one"),
    "track": ("motion", "Track the motion between the keyframes"),
    "camera": (
        "motion",
        "Find how the camera turned, zoomed and moved, from the background of its film",
    ),
    "stand": ("motion", "Stand the tracked motion on its floor: feet pinned, floor and up found"),
    "review": ("motion", "List the places of the motion to look at, the worst first"),
    "reduce": ("motion", "Reduce a dense motion to a few keyframes"),
    "fit": ("motion", "Fit the body to observed surfaces, one mesh per time step"),
    "batch": (
        "motion",
        "Track many saved sessions again, or the films of a table",
    ),
    "evaluate": ("motion", "Measure the tracked motion against a reference"),
    "shot": ("pictures", "Render the body at one frame into a PNG file"),
    "film": ("pictures", "Render the tracked body into an MP4 film (H.264, no sound)"),
    "sheet": ("pictures", "Draw all keyframes on one sheet, a PNG file"),
    "matte": (
        "pictures",
        "Cut the person out of the film: PNG pictures with alpha, or a film with alpha",
    ),
    "report": ("pictures", "Write a report on the tracking as one HTML file"),
    "export": ("files", "Write the tracked motion for other programs"),
    "import": ("files", "Import a motion recorded elsewhere, 2D keypoints, or a camera"),
    "hull": (
        "files",
        "Build one surface per time step from the silhouettes of calibrated cameras",
    ),
    "info": (
        "files",
        "Show a video's size, frames, rate and fingerprint, or a session's bodies",
    ),
    "models": ("files", "List the networks that find keypoints, add or remove one"),
    "schema": ("program", "Print the JSON Schema of a body file or a session file"),
    "config": ("program", "Show the defaults of this computer and the file to change them in"),
    "doctor": ("program", "Check this computer: what is missing, and what to do about it"),
    "completion": ("program", "Print the completion for a shell"),
}
"""The commands in the order of the help: the module of `grammar` that declares it, its
summary without a full stop. It is done by `run` of the module of its name here."""

UNITS = ("m", "dm", "cm", "mm", "in", "ft")
UP_AXES = ("+x", "-x", "+y", "-y", "+z", "-z")
"""As in tracker.session.settings, which would load more than help needs."""

SESSION = "session.json"
SESSION_FOLDER = ".keypose"
"""As in app.document.library, likewise."""

WIDTH = 88
"""Columns of a description, whose examples below it are kept as they are."""


def add_command(
    commands: Subcommands,
    name: str,
    details: str,
    examples: str,
) -> argparse.ArgumentParser:
    """Add a command, which `COMMANDS` sums up."""
    summary = COMMANDS[name][1]
    command = commands.add_parser(
        name,
        help=summary,
        description=textwrap.fill(f"{summary}. {details}", WIDTH),
        epilog=f"examples:\n{examples}",
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    command.set_defaults(run=name)
    return command


SESSION_WORDS = "the session's file or folder, or its video"


def add_session(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "session",
        metavar="SESSION",
        type=session_file,
        nargs="?",
        default=os.curdir,
        help=f"{SESSION_WORDS}; default: the one in this folder",
    )


def add_json(
    command: argparse.ArgumentParser, help_text: str = "print only JSON on stdout"
) -> None:
    command.add_argument("--json", action="store_true", help=help_text)


def add_overwrite(command: argparse.ArgumentParser) -> None:
    command.add_argument("--overwrite", action="store_true", help="overwrite existing files")


def add_output(
    command: argparse.ArgumentParser, name: str, more: str = "the file to write"
) -> None:
    """The file or folder that the command writes, and how that is reported."""
    command.add_argument("--out", metavar=name, type=file_name, required=True, help=more)
    add_json(command)
    add_overwrite(command)


def note(words: str | None) -> None:
    """Words a person should know, on stderr; the work goes on."""
    if words is not None:
        print(f"Note: {words}", file=sys.stderr)


def file_name(text: str) -> Path:
    """A parser of names of files and folders that the system could hold."""
    if not text:
        raise argparse.ArgumentTypeError("a name must not be empty")
    try:
        path = Path(text).expanduser()
        path.exists()
    except (OSError, ValueError, RuntimeError) as problem:
        reason = getattr(problem, "strerror", None) or problem
        raise argparse.ArgumentTypeError(f"{text[:40]!r}… is no name: {reason}") from None
    return path


def session_file(text: str) -> Path:
    """A parser of names of session files, of the folders they lie in, and of their videos. A link
    is followed here, once: what belongs to a session lies beside its file, and is never written
    through a link."""
    path = file_name(text)
    path = _in_folder(path) if path.is_dir() else _of_video(path)
    return Path(os.path.realpath(path)) if path.is_symlink() else path


def is_session_named(path: Path) -> bool:
    """Whether a name is a session's file or folder, not a film."""
    return path.suffix.lower() == ".json" or (path / SESSION).is_file()


def _in_folder(folder: Path) -> Path:
    """The session of a folder: its own, that of the pictures in it, or the only one below it."""
    whole = folder.resolve()
    for path in (folder / SESSION, whole.with_name(f"{whole.name}{SESSION_FOLDER}") / SESSION):
        if path.is_file():
            return path
    below = sorted(folder.glob(f"*{SESSION_FOLDER}/{SESSION}"))
    if len(below) == 1:
        return below[0]
    if below:
        names = ", ".join(path.parent.name for path in below[:3])
        raise argparse.ArgumentTypeError(
            f"there are {len(below)} sessions in {str(folder)!r}, {names}: give one of them"
        )
    raise argparse.ArgumentTypeError(
        f"there is no session in the folder {str(folder)!r}; give a session's file or folder, "
        "or its video"
    )


def _of_video(path: Path) -> Path:
    """The session beside a video; any other name as it is."""
    if path.suffix.lower() == ".json" or not path.is_file():
        return path
    beside = path.with_suffix(SESSION_FOLDER) / SESSION
    if beside.is_file():
        return beside
    raise argparse.ArgumentTypeError(
        f"{path.name!r} has no session beside it; `keypose open {path}` begins one"
    )


def host_name(text: str) -> str:
    """A parser of what stands between http:// and / in an address: a name, maybe with a port."""
    if not re.fullmatch(r"[a-z0-9]([a-z0-9.-]{0,251}[a-z0-9])?(:\d{1,5})?", text.lower()):
        raise argparse.ArgumentTypeError(
            f"{text[:40]!r} is no host name; such as keypose.example.org or workshop.lan:8090"
        )
    return text.lower()


def add_work(command: argparse.ArgumentParser) -> None:
    """Add the options of work on a session's segments: where results go, how many at a time, how it
    is printed.
    """
    command.add_argument(
        "--out", metavar="DIR", type=file_name, help="folder for session and results"
    )
    command.add_argument(
        "--workers",
        metavar="N",
        type=typed(Whole(least=1)),
        default=1,
        help="segments to track at the same time; default: 1",
    )
    add_json(command, "print events as JSON lines on stdout, with the summary last")
    add_overwrite(command)


def motion_formats(text: str) -> tuple[MotionFormat, ...]:
    """File formats of motion, with commas between."""
    try:
        return formats_of(text)
    except FormatError as error:
        raise argparse.ArgumentTypeError(str(error).rstrip(".")) from None


def add_order(command: argparse.ArgumentParser, order: type, *, but: Container[str] = ()) -> None:
    """Add the options of an order; what is given of them is found by `order_of`.

    but: fields that another order of the command has already, which mean the same.
    """
    options = [(name, option) for name, option in options_of(order).items() if name not in but]
    _add_options(command, options, order)


def add_orders(command: argparse.ArgumentParser, orders: Mapping[str, type]) -> None:
    """Add the options of several kinds of orders, those that are alike once, each kind by its name
    in a group of the help."""
    kinds_of: dict[str, list[str]] = {}
    for kind, order in orders.items():
        for name in options_of(order):
            kinds_of.setdefault(name, []).append(kind)
    for kinds in dict.fromkeys(map(tuple, kinds_of.values())):
        order = orders[kinds[0]]
        mine = [
            (n, option) for n, option in options_of(order).items() if tuple(kinds_of[n]) == kinds
        ]
        _add_options(command.add_argument_group(listed(kinds)), mine, order)


def add_film_orders(command: argparse.ArgumentParser) -> None:
    for order in FILM_ORDERS.values():
        add_order(command, order)


def film_orders_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """What is said of a film, by the fields of `FilmToDraft`."""
    said: dict[str, Any] = {name: order_of(order, arguments) for name, order in FILM_ORDERS.items()}
    require_whom(said["order"])
    return said


def require_of(
    order: type, others: Mapping[str, type], arguments: argparse.Namespace, subject: str
) -> None:
    """FormatError for an option of another kind, which would be ignored in silence, and for a
    value that this kind does not have."""
    own = options_of(order)
    for name, option in own.items():
        value = getattr(arguments, name, None)
        if value is None or not isinstance(option.value, Choice) or not option.value.names:
            continue
        if value not in map(option.value.read, option.value.names):
            chosen = f"{_flag(name, option)} {str(value).replace(' ', '-')}"
            raise FormatError(
                f"{chosen} is not for {subject}: choose from {', '.join(option.value.names)}."
            )
    for kind, order_of_kind in others.items():
        for name, option in options_of(order_of_kind).items():
            if name not in own and getattr(arguments, name) is not None:
                raise FormatError(f"{_flag(name, option)} is for {kind}, not for {subject}.")


def _flag(name: str, option: Option) -> str:
    return f"--{option.flag or name.replace('_', '-')}"


def _add_options(place: Any, options: Iterable[tuple[str, Option]], order: type) -> None:
    for name, option in options:
        if option.flag != "":
            place.add_argument(
                _flag(name, option),
                dest=name,
                help=_help(order, name, option),
                default=None,
                **_how(option),
            )


def _how(option: Option) -> dict[str, Any]:
    if isinstance(option.value, Switch):
        return {"action": "store_true"}
    names = getattr(option.value, "names", ())
    metavar = option.value.metavar or (f"{{{','.join(names)}}}" if names else None)
    repeated = {"action": "append"} if option.repeated else {"action": Once} if option.once else {}
    choices = {"choices": names} if type(option.value) is Choice else {}  # for a shell to complete
    return {"type": typed(option.value), "metavar": metavar, **choices, **repeated}


class Once(argparse.Action):
    """Stores a value and refuses a second one, but of a command that takes `more_` of it."""

    def __call__(self, *parser_arguments: Any, **_: Any) -> None:
        _parser, namespace, value, *_rest = parser_arguments
        more = f"more_{self.dest}"
        if getattr(namespace, self.dest) in (None, self.default):
            setattr(namespace, self.dest, value)
        elif hasattr(namespace, more):
            setattr(namespace, more, (*getattr(namespace, more), value))
        else:
            raise argparse.ArgumentError(self, "is given twice")


def _help(order: type, name: str, option: Option) -> str:
    usual = order.__dataclass_fields__[name].default  # type: ignore[attr-defined]
    return f"{option.words}; default: {usual}" if isinstance(usual, str) else option.words


def typed(value: Value) -> Callable[[str], Any]:
    """What reads such a value for the parser."""

    def parse(text: str) -> Any:
        try:
            return value.read(text)
        except Misread as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return parse


def order_of(
    order: type[OrderT], arguments: argparse.Namespace, *, but: Container[str] = ()
) -> OrderT:
    """The order that was given; FormatError for two options that mean the same.

    but: fields that mean something else here.
    """
    options = {name: option for name, option in options_of(order).items() if name not in but}
    all_given = {name: getattr(arguments, name, None) for name in options}
    values = {name: value for name, value in all_given.items() if value is not None}
    require_one_of_each_group(options, values, lambda name: _flag(name, options[name]))
    return order(**{name: tuple(v) if options[name].repeated else v for name, v in values.items()})
