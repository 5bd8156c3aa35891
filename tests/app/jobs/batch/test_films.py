"""Films by paths and tables: which are meant, what is said of each, where its session goes."""

from __future__ import annotations

from pathlib import Path

import pytest

from keypose.app.jobs.batch.films import films_in, placed, read_table
from keypose.app.orders.film import FilmOrder, FilmToDraft
from keypose.tracker.errors import FormatError, KeyposeError, SessionError


def table(folder: Path, *rows: str, name: str = "films.csv") -> Path:
    path = folder / name
    path.write_text("\n".join(rows), encoding="utf-8")
    return path


ROWS = {
    "commas": ("film,box,body,height,lens,frames", 'a.mp4,"1,2,30,40",child,131,26,0-9'),
    "semicolons": ("film;box;body;height;lens;frames", "a.mp4;1,2,30,40;child;131 cm;26mm;0-9"),
    "tabs, and spaces in a box": (
        "Film\tBox\tBody\tHeight\tLens\tFrames", "a.mp4\t1 2 30 40\tchild\t131\t26\t0-9",
    ),
    "another order, a mark of Excel's": (
        "\ufefflens,film,frames,--height,body,box", '26,a.mp4,0-9,131,child,"1,2,30,40"',
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", ROWS)
def test_a_table_says_of_each_film_what_options_would(tmp_path: Path, kind: str) -> None:
    header, row = ROWS[kind]
    (film,) = read_table(table(tmp_path, header, row, ""))
    assert film.path == tmp_path / "a.mp4"
    assert film.order == FilmOrder(
        box=(1.0, 2.0, 30.0, 40.0), body="child", height_cm=131.0, lens_mm=26.0, frames=(0, 9)
    )


def test_what_is_empty_in_a_table_is_left_out(tmp_path: Path) -> None:
    films = read_table(table(tmp_path, "film,box,recorded_fps", "a.mp4,,", "b.mp4,,240"))
    assert films[0] == FilmToDraft(tmp_path / "a.mp4")
    assert films[1].taken.recorded_fps == 240.0


def test_a_row_names_other_films_of_its_motion_from_the_tables_folder_on(tmp_path: Path) -> None:
    touch(tmp_path, "b.mp4", "more/c.mp4")
    (film,) = read_table(table(tmp_path, "film,beside", "a.mp4,b.mp4 | more/c.mp4"))
    assert film.beside == (tmp_path / "b.mp4", tmp_path / "more" / "c.mp4")


WRONG = {
    "no film column": (("video,box", "a.mp4,"), "has no column 'film'"),
    "an unknown column": (
        ("film,size", "a.mp4,3"),
        "has a column 'size'; known are film, name, beside, box",
    ),
    "a column twice": (("film,box,box", "a.mp4,,"), "has a column twice"),
    "a row without a film": (("film,box", ",3"), "films.csv, row 2: the film is missing"),
    "a wrong box": (
        ("film,box", "a.mp4,", "b.mp4,him"),
        "films.csv, row 3, box: 'him' is not a box",
    ),
    "a box and everyone": (
        ("film;box;everyone", "a.mp4;1,2,30,40;true"),
        "row 2: --box names a person and --everyone means all",
    ),
    "a wrong body": (("film,body", "a.mp4,giant"), "row 2, body: invalid choice: 'giant'"),
    "another film that is gone": (
        ("film,beside", "a.mp4,gone.mp4"),
        "films.csv, row 2, beside: there is no film",
    ),
    "two lenses": (
        ("film,lens,field_of_view", "a.mp4,26,60"),
        "row 2: field_of_view and lens",
    ),
    "nothing": ((), "is empty"),
    "a header alone": (("film,box",), "names no film"),
    "a comma too many": (("film,height", "a.mp4,170,5"), "row 2, has more values than there are"),
    "a name that leads elsewhere": (("film,name", "a.mp4,../b"), "cannot be the name of a folder"),
    "a hidden name": (("film,name", "a.mp4,.b"), "cannot be the name of a folder"),
    "quotes that never end": (("film,box", 'a.mp4,"1,2'), "is no table"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_a_table_that_cannot_be_read_is_said_in_one_sentence(tmp_path: Path, wrong: str) -> None:
    rows, words = WRONG[wrong]
    with pytest.raises(FormatError) as refused:
        read_table(table(tmp_path, *rows))
    assert words in str(refused.value)


def test_bytes_that_are_no_text_are_no_table(tmp_path: Path) -> None:
    (tmp_path / "films.csv").write_bytes(b"film\n\xff\xfe\x00")
    with pytest.raises(FormatError, match="no text in UTF-8"):
        read_table(tmp_path / "films.csv")


def touch(folder: Path, *names: str) -> list[Path]:
    paths = [folder / name for name in names]
    for path in paths:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
    return paths


def test_a_folder_stands_for_its_films_and_one_of_images_for_itself(tmp_path: Path) -> None:
    touch(tmp_path / "films", "b.mov", "a.mp4", "notes.txt", ".hidden.mp4", "deeper/c.mp4")
    touch(tmp_path / "images", "1.png", "2.png")
    found = films_in([tmp_path / "films", tmp_path / "images", tmp_path / "films" / "a.mp4"])
    assert [path.name for path in found] == ["a.mp4", "b.mov", "images"]


@pytest.mark.parametrize("wrong", ["gone", "empty"])
def test_where_there_is_no_film_that_is_said(tmp_path: Path, wrong: str) -> None:
    (tmp_path / "empty").mkdir()
    with pytest.raises(KeyposeError, match="There is no film"):
        films_in([tmp_path / wrong])


def test_each_film_has_a_session_of_its_own_whatever_it_is_called(tmp_path: Path) -> None:
    films = touch(tmp_path, "one/jump.mp4", "two/jump.mp4", "two/jump.mov", "two/swing.mp4")
    rows = placed([FilmToDraft(film) for film in films], tmp_path / "out")
    assert [row.session.relative_to(tmp_path / "out").as_posix() for row in rows] == [
        "one/jump.keypose/session.json",
        "two/jump.keypose/session.json",
        "two/jump.mov.keypose/session.json",
        "swing.keypose/session.json",
    ]
    assert [row.name for row in rows] == ["one/jump", "two/jump", "two/jump.mov", "swing"]
    (beside,) = placed([FilmToDraft(films[0])], None)
    assert beside.session == tmp_path / "one" / "jump.keypose" / "session.json"


def test_several_people_of_one_film_have_sessions_by_their_names(tmp_path: Path) -> None:
    touch(tmp_path, "dance.mp4")
    rows = ("film,name,box", 'dance.mp4,Ann,"1,2,30,40"', 'dance.mp4,Bo,"5,2,30,40"', "dance.mp4,,")
    placed_films = placed(read_table(table(tmp_path, *rows)), tmp_path / "out")
    assert [row.name for row in placed_films] == ["Ann", "Bo", "dance"]
    unnamed = [FilmToDraft(tmp_path / "dance.mp4")] * 3
    with pytest.raises(SessionError, match="give each a name of its own"):
        placed(unnamed, tmp_path / "out")


def test_a_table_is_no_film(tmp_path: Path) -> None:
    with pytest.raises(SessionError, match="is a table: `keypose batch"):
        films_in([table(tmp_path, "film", "a.mp4")])
