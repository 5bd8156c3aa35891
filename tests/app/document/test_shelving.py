"""Sessions are renamed, duplicated, deleted and put back; the video is never touched."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from keypose.app.document.folder_lock import SessionLock
from keypose.app.document.library import Library, id_of
from keypose.app.document.library.session_files import session_files
from keypose.app.document.open import open_for_editing
from keypose.tracker.errors import KeyposeError, SessionError
from keypose.tracker.storage.files import load_session, open_video_of
from tests.app.serving import ROOT


@pytest.fixture
def home(tmp_path: Path) -> Path:
    return tmp_path / "home"


@pytest.fixture
def session(home: Path) -> Path:
    """One in a folder of its own beside its video, with tracked motion and other people's files."""
    folder = home / "jump.keypose"
    folder.mkdir(parents=True)
    sample = ROOT / "sample_videos" / "box"
    shutil.copy(sample / "box.mp4", home / "jump.mp4")
    text = (sample / "session.json").read_text().replace('"box.mp4"', '"../jump.mp4"')
    (folder / "session.json").write_text(text)
    (folder / "tracks-0123456789ab.npz").write_bytes(b"motion")
    (folder / "session.json.previous").write_text(text)
    return folder / "session.json"


@pytest.fixture
def library(tmp_path: Path, home: Path, session: Path) -> Library:
    library = Library(tmp_path / "workspace", [home])
    library.remember(session, load_session(session))
    return library


def the_id(path: Path) -> str:
    return id_of(str(path))


def names(library: Library) -> list[str]:
    return [one.name for one in library.recents()]


def files(folder: Path) -> dict[str, bytes]:
    return {
        str(f.relative_to(folder)): f.read_bytes()
        for f in sorted(folder.rglob("*"))
        if f.is_file() and f.name != ".keypose.lock"
    }


def test_a_session_gets_another_name_which_undo_takes_back(library: Library, session: Path) -> None:
    library.rename(the_id(session), "  Second   try ")
    assert names(library) == ["Second try"]
    assert [f["name"] for f in library.contents()["files"] if f["kind"] == "session"] == [
        "Second try"
    ]
    opened = open_for_editing(session, library.session_for)
    opened.video.close()
    assert opened.session.title == "Second try"
    assert [step.label for step in opened.history.past] == ["rename"]
    assert opened.history.past[-1].doc.title == ""
    assert not opened.news  # it was not changed by another program
    library.rename(the_id(session), "")
    assert names(library) == ["jump"]


def test_a_copy_leads_to_the_same_video_and_has_the_motion(library: Library, session: Path) -> None:
    before = files(session.parent)
    id, name = library.duplicate(the_id(session))
    copy = library.find("recent", id)
    assert name == "jump 2"
    assert copy == session.parent.parent / "jump 2.keypose" / "session.json"
    assert (copy.parent / "tracks-0123456789ab.npz").read_bytes() == b"motion"
    with open_video_of(load_session(copy), copy) as video:
        assert video.info.path.resolve() == (session.parent.parent / "jump.mp4").resolve()
    assert files(session.parent) == before
    assert names(library) == ["jump 2", "jump"]


def test_a_deleted_session_leaves_its_video_and_comes_back_as_it_was(
    library: Library, session: Path, home: Path
) -> None:
    before = files(home)
    in_trash, name = library.delete(the_id(session))
    assert name == "jump"
    assert names(library) == []
    assert list(files(home)) == ["jump.mp4"]
    assert not session.parent.exists()
    library.restore(in_trash)
    assert files(home) == before
    assert names(library) == ["jump"]
    with pytest.raises(KeyposeError, match="not in the trash"):
        library.restore(in_trash)


def test_of_a_folder_with_a_video_and_another_session_only_the_deleted_one_goes(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "mixed"
    shutil.copytree(ROOT / "sample_videos" / "box", folder)
    tracks = "tracks-aaaaaaaaaaaa.npz"
    text = (folder / "session.json").read_text()
    (folder / "other.json").write_text(text.replace("{", f'{{"note": "{tracks}",', 1))
    for name in (tracks, "tracks-bbbbbbbbbbbb.npz", "notes.txt"):
        (folder / name).touch()
    found = [file.name for file in session_files(folder / "other.json")]
    assert found == ["other.json", tracks]
    assert [file.name for file in session_files(folder / "session.json")] == ["session.json"]


def test_a_session_that_another_keypose_has_is_left_alone_and_said(
    library: Library, session: Path, home: Path
) -> None:
    before = files(home)
    with SessionLock.take(session.parent):
        for act in (library.delete, lambda id: library.rename(id, "other")):
            with pytest.raises(SessionError, match=r"open in another Keypose .*close it there"):
                act(the_id(session))
    assert files(home) == before


def test_what_lies_there_by_now_is_not_overwritten(library: Library, session: Path) -> None:
    in_trash, _ = library.delete(the_id(session))
    session.parent.mkdir()
    session.write_text("another")
    with pytest.raises(KeyposeError, match="is there again"):
        library.restore(in_trash)
    assert session.read_text() == "another"


@pytest.mark.parametrize("id", ["", "../../etc", "0" * 16, "/"])
def test_an_id_of_the_trash_leads_nowhere_else(library: Library, id: str) -> None:
    with pytest.raises(KeyposeError, match="not in the trash"):
        library.restore(id)


def test_where_files_cannot_be_moved_all_stays(
    library: Library, session: Path, home: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before, moved = files(home), []

    def move(source: Path, place: Path) -> None:
        if len(moved) == 1:
            moved.append(None)
            raise OSError(28, "No space left on device")
        moved.append(place)
        Path(source).rename(place)

    monkeypatch.setattr(shutil, "move", move)
    with pytest.raises(SessionError, match="No space left"):
        library.delete(the_id(session))
    assert files(home) == before
    assert names(library) == ["jump"]
