"""Foreign files are read as regular files of a sensible size; Keypose's own through no link."""

from __future__ import annotations

import ast
import os
import socket
import stat
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from keypose.tracker.body.body import load_body
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import BodyError, FormatError, KeyposeError, SessionError, SurfaceError
from keypose.tracker.files import (
    NotRegular,
    TooLarge,
    open_own,
    open_regular,
    read_head,
    read_own,
    read_private,
    read_regular,
    read_unshared,
)
from keypose.tracker.formats.joint_names import load_names
from keypose.tracker.formats.reading import load_motion
from keypose.tracker.formats.reading_keypoints import load_keypoints
from keypose.tracker.formats.reference import load_reference
from keypose.tracker.storage.atomic import write_file
from keypose.tracker.storage.evidence.files import MOST_CAMERA_BYTES
from keypose.tracker.storage.files import load_session
from keypose.tracker.storage.journal import Journal, read_journal
from keypose.tracker.surface.cameras.rig import Rig
from tests.tracker import session_cases as cases

NOT_FILES = ("pipe", "device", "socket", "folder")


@contextmanager
def made(kind: str, path: Path) -> Iterator[Path]:
    """Something at the path that is no regular file."""
    listener = None
    if kind == "pipe":
        os.mkfifo(path)
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "socket":
        listener = socket.socket(socket.AF_UNIX)
        listener.bind(str(path))
    else:
        path.mkdir()
    try:
        yield path
    finally:
        if listener is not None:
            listener.close()


@pytest.fixture
def short(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder whose name leaves room for a socket's."""
    return tmp_path_factory.mktemp("s")


@pytest.mark.parametrize("kind", NOT_FILES)
@pytest.mark.parametrize("read", [lambda p: open_regular(p), lambda p: read_regular(p, 9),
                                  lambda p: read_head(p, 9), lambda p: read_own(p, 9)])  # fmt: skip
def test_what_is_no_regular_file_is_never_read(
    kind: str, read: Callable[[Path], object], short: Path
) -> None:
    with made(kind, short / "it") as path, pytest.raises(NotRegular):
        read(path)


def test_a_pipe_put_there_after_the_look_is_not_waited_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pipe, plain = tmp_path / "pipe", tmp_path / "plain"
    os.mkfifo(pipe)
    plain.write_bytes(b"x")
    looked = plain.stat()
    monkeypatch.setattr(Path, "stat", lambda *_, **__: looked)
    with pytest.raises(NotRegular):
        open_regular(pipe)


def test_no_more_is_read_than_is_allowed(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"12345")
    assert read_regular(path, 5) == b"12345"
    assert read_head(path, 4) == b"1234"
    with pytest.raises(TooLarge):
        read_regular(path, 4)


def test_a_file_that_claims_no_size_is_not_believed() -> None:
    claims_nothing = Path("/proc/self/maps")
    if not claims_nothing.exists():
        pytest.skip("there is no /proc")
    assert claims_nothing.stat().st_size == 0
    with pytest.raises(TooLarge):
        read_regular(claims_nothing, 10)


def load_any_reference(path: Path) -> object:
    return load_reference(path, Skeleton.of(cases.session().subject.body))


READERS: dict[str, Callable[[Path], object]] = {
    "session.json": load_session,
    "body.json": load_body,
    "names.json": load_names,
    "coco.json": load_keypoints,
    "cameras.json": Rig.open,
    "motion.bvh": load_motion,
    "motion.csv": load_motion,
    "marks.json": load_any_reference,
    "truth.npz": load_any_reference,
}


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize("kind", ["pipe", "device"])
def test_every_reader_refuses_what_never_ends_in_one_sentence(
    kind: str, name: str, tmp_path: Path
) -> None:
    with made(kind, tmp_path / name) as path, pytest.raises(KeyposeError) as reported:
        READERS[name](path)
    assert isinstance(reported.value, BodyError | FormatError | SessionError | SurfaceError)
    assert "not a regular file" in str(reported.value)


# --- Keypose's own


def test_a_link_is_not_followed_to_write(tmp_path: Path) -> None:
    precious, link = tmp_path / "v.txt", tmp_path / "own"
    precious.write_bytes(b"precious")
    link.symlink_to(precious)
    with pytest.raises(NotRegular, match="link"):
        open_own(link, os.O_WRONLY | os.O_CREAT)


def test_a_link_to_nowhere_makes_no_file_there(tmp_path: Path) -> None:
    (tmp_path / "own").symlink_to(tmp_path / "new")
    with pytest.raises(NotRegular):
        open_own(tmp_path / "own", os.O_WRONLY | os.O_CREAT)
    assert not (tmp_path / "new").exists()


def test_a_file_with_a_second_name_is_read_and_not_written(tmp_path: Path) -> None:
    first, second = tmp_path / "first", tmp_path / "second"
    first.write_bytes(b"x")
    second.hardlink_to(first)
    assert read_own(second, 9) == b"x"
    with pytest.raises(NotRegular, match="another name"):
        open_own(second, os.O_WRONLY)


def test_a_link_put_there_after_the_look_is_not_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    precious, link = tmp_path / "v.txt", tmp_path / "own"
    precious.write_bytes(b"precious")
    link.symlink_to(precious)
    looked = precious.stat()
    monkeypatch.setattr(Path, "lstat", lambda *_: looked)
    with pytest.raises(OSError):  # noqa: PT011 — ELOOP, by whatever name the system has for it
        open_own(link, os.O_WRONLY)


def test_an_own_file_is_made_where_there_is_none(tmp_path: Path) -> None:
    os.close(open_own(tmp_path / "own", os.O_WRONLY | os.O_CREAT, 0o600))
    assert stat.S_IMODE((tmp_path / "own").stat().st_mode) == 0o600


@pytest.mark.parametrize("link", ["symbolic", "hard"])
def test_a_journal_that_leads_elsewhere_is_begun_anew_in_its_own_place(
    tmp_path: Path, link: str
) -> None:
    precious, path = tmp_path / "v.txt", tmp_path / "journal.jsonl"
    precious.write_bytes(b"precious")
    path.symlink_to(precious) if link == "symbolic" else path.hardlink_to(precious)
    journal = Journal(path, 0)
    assert not journal.is_there()
    with pytest.raises(SessionError, match="cannot be written"):
        journal.append([{"saved": "x"}])
    journal.begin_anew([{"saved": "x"}])
    journal.append([{"saved": "y"}])
    journal.close()
    assert precious.read_bytes() == b"precious"
    assert [record["saved"] for record in read_journal(path).records] == ["x", "y"]


def test_cameras_beyond_their_size_are_recognized_by_their_beginning(tmp_path: Path) -> None:
    path = tmp_path / "cameras.json"
    path.write_bytes(b" " * (MOST_CAMERA_BYTES + 1))
    assert len(read_head(path, MOST_CAMERA_BYTES)) == MOST_CAMERA_BYTES


@pytest.mark.skipif(os.name != "posix", reason="modes are POSIX's")
def test_what_others_may_read_is_not_taken_for_private(tmp_path: Path) -> None:
    path = tmp_path / "secret"
    write_file(path, b"x", private=True)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert read_private(path, 9) == b"x"
    path.chmod(0o640)
    with pytest.raises(NotRegular, match="others may read"):
        read_private(path, 9)
    write_file(path, b"y", overwrite=True, private=True)
    assert read_private(path, 9) == b"y"


# --- all readers

OWN_READS = {
    "app/export/opensim_files.py": "a file that was just written",
    "app/export/report/markup.py": "the program's own sheets and pictures",
    "app/server/page_files.py": "the page, which comes with the program",
    "tracker/body/body.py": "a body that comes with the program",
    "tracker/formats/marker_files.py": "a file that was just written",
    "tracker/formats/joint_names.py": "a table that comes with the program",
    "tracker/formats/rigs/table.py": "tables that come with the program",
    "tracker/formats/usd.py": "a file that was just written",
    "tracker/kernels/compiling.py": "the program's own text",
    "tracker/keypoints/known_person.py": "a picture that comes with the program",
    "tracker/limits.py": "a number of the system's",
    "tracker/storage/atomic.py": "what was just seen to be a regular file",
    "tracker/video/encode.py": "a file that was just written",
}
"""Where a file is read without `keypose.tracker.files`, and what it is."""


def reads_of(path: Path) -> bool:
    """Whether a module reads files by itself."""
    calls = [node for node in ast.walk(ast.parse(path.read_text("utf-8")))
             if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)]  # fmt: skip
    modes = [
        call.args[0].value
        for call in calls
        if call.func.attr == "open" and call.args and isinstance(call.args[0], ast.Constant)
    ]
    names = {call.func.attr for call in calls}
    return bool(names & {"read_bytes", "read_text"}) or "r" in modes or "rb" in modes


def test_all_other_readers_open_files_in_this_way() -> None:
    root = Path(__file__).parents[2]
    modules = [path for package in ("app", "tracker") for path in (root / package).rglob("*.py")]
    found = {path.relative_to(root).as_posix() for path in modules if reads_of(path)}
    assert found == set(OWN_READS)


@pytest.mark.skipif(os.name != "posix", reason="modes say nothing here")
def test_what_others_may_change_or_exchange_is_not_trusted(tmp_path: Path) -> None:
    folder = tmp_path / "above" / "folder"
    folder.mkdir(parents=True)
    file = folder / "note"
    file.write_bytes(b"a note")
    assert read_unshared(file, 9) == b"a note"
    for place in (file, folder, folder.parent):
        before = place.stat().st_mode
        place.chmod(before | stat.S_IWOTH)
        with pytest.raises(NotRegular, match="run chmod go-w on it"):
            read_unshared(file, 9)
        place.chmod(before)
    folder.parent.chmod(0o1777)  # as /tmp, in which nobody moves what is another's
    assert read_unshared(file, 9) == b"a note"
    folder.parent.chmod(0o755)
    with pytest.raises(TooLarge):
        read_unshared(file, 5)
    (folder / "link").symlink_to(file)
    with pytest.raises(NotRegular, match="link"):
        read_unshared(folder / "link", 9)
    other = tmp_path / "other"
    other.symlink_to(folder)
    assert read_unshared(other / "note", 9) == b"a note"
    folder.parent.chmod(0o777)
    with pytest.raises(NotRegular, match="other users may write"):
        read_unshared(other / "note", 9)
