"""Which films are meant by paths or by a table of films, and where the session of each goes."""

from __future__ import annotations

import csv
import os
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final, NamedTuple

from keypose.app.document.library.files import SESSION_FOLDER, kind_of, kind_of_folder
from keypose.app.document.library.session_files import SESSION, session_in, session_name
from keypose.app.orders.film import FILM_ORDERS, FilmToDraft, require_whom
from keypose.app.orders.order import Option, options_of, require_one_of_each_group
from keypose.app.orders.values import Misread
from keypose.tracker.errors import FormatError, SessionError
from keypose.tracker.files import read_regular

TABLES: Final = (".csv", ".tsv")
"""Endings of tables of films."""
LARGEST_TABLE_BYTES: Final = 4 * 2**20
MOST_FILMS: Final = 10_000
"""Of a table of films: its bytes and rows."""
FILM: Final = "film"
"""The column of the films."""
NAME: Final = "name"
"""The column of what their sessions are called, where not as the films."""
BESIDE: Final = "beside"
SEPARATOR: Final = "|"
"""The column of other films of the same motion, and what stands between several."""
PLAIN_NAME: Final = re.compile(r"[^\x00-\x1f/\\:*?\"<>|.][^\x00-\x1f/\\:*?\"<>|]{0,99}")
"""What any system takes for the name of a folder."""
DELIMITERS: Final = ",;\t"


class PlacedFilm(NamedTuple):
    """A film, the name it goes by, and the file of its session, which may not exist yet."""

    film: FilmToDraft
    name: str
    session: Path


def is_table(path: Path) -> bool:
    """Whether a path names a table of films."""
    return path.suffix.lower() in TABLES


def films_in(paths: Sequence[Path]) -> tuple[Path, ...]:
    """The films that paths name, each once: a film or a folder of images stands for itself, another
    folder for the films in it, by name. SessionError where one is not there or holds none."""
    films: dict[str, Path] = {}
    for path in paths:
        for film in _films_of(path):
            films.setdefault(os.path.realpath(film), film.absolute())
    return tuple(films.values())


def _films_of(path: Path) -> list[Path]:
    if not path.exists():
        raise SessionError(f"There is no film {str(path)!r}.")
    if is_table(path):
        raise SessionError(f"{path.name} is a table: `keypose batch {path}` takes its films.")
    if not path.is_dir():
        return [path]
    inside = sorted(p for p in path.iterdir() if not p.name.startswith("."))
    films = [p for p in inside if p.is_file() and kind_of(p) == "video"]
    if films:
        return films
    kind, count = kind_of_folder([p.name for p in inside])
    if kind == "images" and count > 1:
        return [path]
    raise SessionError(f"There is no film in the folder {str(path)!r}.")


def placed(films: Sequence[FilmToDraft], out: Path | None) -> list[PlacedFilm]:
    """Films with the files of their sessions: in a folder, else beside each. Films of one name lie
    in folders there as they do where they are. SessionError where these are on several drives."""
    names = Counter(session_name(film.path) for film in films)
    taken: set[Path] = set()
    rows = []
    for film in films:
        below = Path()
        if names[session_name(film.path)] > 1:
            below = film.path.parent.relative_to(_common_folder(films))
        place = film.path.parent if out is None else out.absolute() / below
        session = session_in(place, film.path)
        if film.name is not None:
            session = place / f"{film.name}{SESSION_FOLDER}" / SESSION
        elif session in taken:  # jump.mov beside jump.mp4
            session = place / f"{film.path.name}{SESSION_FOLDER}" / SESSION
        if session in taken:
            raise SessionError(
                f"Several films would have the session {session.parent.name}: give each a name of "
                "its own, in a column `name` of a table."
            )
        taken.add(session)
        name = (below / session.parent.name.removesuffix(SESSION_FOLDER)).as_posix()
        rows.append(PlacedFilm(film, name, session))
    return rows


def _common_folder(films: Sequence[FilmToDraft]) -> Path:
    try:
        return Path(os.path.commonpath([film.path.parent for film in films]))
    except ValueError:
        raise SessionError("Films of one name lie on different drives: give them apart.") from None


# --- tables


def read_table(path: Path) -> list[FilmToDraft]:
    """The films of a table, a row each, with what is said of each in columns that are named as the
    options of `keypose draft`; FormatError in one sentence, with the row, for what is wrong."""
    rows = _rows(path)
    header, options = rows[0], _columns()
    columns = [name.strip().lower().lstrip("-").replace("-", "_") for name in header]
    if FILM not in columns:
        raise FormatError(f"{path.name} has no column {FILM!r}: name the columns in its first row.")
    unknown = [name for name in columns if name not in (FILM, NAME, BESIDE, *options)]
    if unknown:
        columns_read = ", ".join([FILM, NAME, BESIDE, *options])
        raise FormatError(
            f"{path.name} has a column {unknown[0][:40]!r}; known are {columns_read}."
        )
    if len(set(columns)) < len(columns):
        raise FormatError(f"{path.name} has a column twice.")
    films = []
    for number, row in enumerate(rows[1:], start=2):
        if any(cell.strip() for cell in row[len(columns) :]):
            raise FormatError(
                f"{path.name}, row {number}, has more values than there are columns: put values "
                "with commas in quotes."
            )
        if any(cell.strip() for cell in row):
            films.append(_film(path, number, dict(zip(columns, row, strict=False))))
    if not films:
        raise FormatError(f"{path.name} names no film.")
    return films


def _rows(path: Path) -> list[list[str]]:
    try:
        text = read_regular(path, LARGEST_TABLE_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError:
        raise FormatError(f"{path.name} is no text in UTF-8.") from None
    except OSError as error:
        raise FormatError(f"{path.name} cannot be read: {error.strerror or error}.") from None
    lines = text.splitlines()
    if not lines:
        raise FormatError(f"{path.name} is empty.")
    if len(lines) > MOST_FILMS + 1:
        raise FormatError(f"{path.name} has more than {MOST_FILMS} rows.")
    between = max(DELIMITERS, key=lines[0].count)
    try:
        return list(csv.reader(lines, delimiter=between, strict=True))
    except csv.Error as error:
        raise FormatError(f"{path.name} is no table: {error}.") from None


def _columns() -> dict[str, tuple[str, str, Option]]:
    """Order and field by the name of a column."""
    return {
        (option.flag or name).replace("-", "_"): (order, name, option)
        for order, of in FILM_ORDERS.items()
        for name, option in options_of(of).items()
    }


def _film(table: Path, number: int, cells: Mapping[str, str]) -> FilmToDraft:
    row = f"{table.name}, row {number}"
    name = cells[FILM].strip() if cells.get(FILM) else ""
    if not name:
        raise FormatError(f"{row}: the film is missing.")
    path = _place(table, name)
    beside = [cell.strip() for cell in cells.get(BESIDE, "").split(SEPARATOR)]
    said: dict[str, dict[str, Any]] = {order: {} for order in FILM_ORDERS}
    for column, (order, field, option) in _columns().items():
        if not (text := cells.get(column, "").strip()):
            continue
        try:
            said[order][field] = option.value.read(text)
        except Misread as error:
            raise FormatError(f"{row}, {column}: {str(error).rstrip('.')}.") from None
    for order, of in FILM_ORDERS.items():
        _require_one_each(of, said[order], row)
    called = cells.get(NAME, "").strip() or None
    if called is not None and not PLAIN_NAME.fullmatch(called):
        raise FormatError(f"{row}, name: {called[:40]!r} cannot be the name of a folder.")
    orders = {order: of(**said[order]) for order, of in FILM_ORDERS.items()}
    with _in_row(row):
        require_whom(orders["order"])
    others = tuple(_place(table, each) for each in beside if each)
    gone = next((each for each in others if not each.exists()), None)
    if gone is not None:
        raise FormatError(f"{row}, beside: there is no film {str(gone)!r}.")
    return FilmToDraft(path, **orders, name=called, beside=others)


def _place(table: Path, name: str) -> Path:
    """Where a film is that a table names: from the table's folder on."""
    return (table.absolute().parent / Path(name).expanduser()).absolute()


def _require_one_each(order: type, said: Iterable[str], row: str) -> None:
    options = options_of(order)
    with _in_row(row):
        require_one_of_each_group(options, said, lambda name: options[name].flag or name)


@contextmanager
def _in_row(row: str) -> Iterator[None]:
    """Say in which row a FormatError is."""
    try:
        yield
    except FormatError as error:
        raise FormatError(f"{row}: {error}") from None
