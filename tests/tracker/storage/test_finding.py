"""A session's video where it was moved or renamed: among much else, and where names are odd."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from keypose.tracker.errors import SessionError
from keypose.tracker.storage import files
from keypose.tracker.storage.files import load_session, open_video_of
from tests.tracker import session_cases as cases

SAMPLES = Path(__file__).resolve().parents[3] / "sample_videos"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A session of a film that is one file."""
    folder = tmp_path / "take"
    folder.mkdir()
    for name in ("box.mp4", "session.json"):
        shutil.copyfile(SAMPLES / "box" / name, folder / name)
    return folder / "session.json"


def found(path: Path) -> Path:
    with open_video_of(load_session(path), path) as video:
        return video.info.path.resolve()


def test_a_path_with_a_nul_character_is_looked_for_elsewhere(path: Path) -> None:
    cases.altered(path, lambda data: data["video"].update(path="a\0b/c.mp4"))
    assert found(path) == path.with_name("box.mp4")
    path.with_name("box.mp4").unlink()
    with pytest.raises(SessionError, match="missing"):
        open_video_of(load_session(path), path)


def test_the_old_name_is_looked_at_however_many_files_there_are(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "MOST_FILES", 1)
    for number in range(5):
        path.with_name(f"a{number}.mp4").write_bytes(b"-")
    moved = path.with_name("box.mp4").rename(path.parents[1] / "box.mp4")
    (path.parents[1] / "a.mp4").write_bytes(b"-")
    assert found(path) == moved


def test_files_that_are_no_films_take_no_place_of_those_looked_at(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(files, "MOST_FILES", 1)
    path.with_name("a.json").write_text("{}")
    moved = path.with_name("box.mp4").rename(path.with_name("renamed.mp4"))
    assert found(path) == moved


def test_a_file_that_cannot_be_looked_at_is_passed_over(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path.with_name("a.mp4").write_bytes(b"-")
    moved = path.with_name("box.mp4").rename(path.with_name("renamed.mp4"))
    is_file = Path.is_file

    def stumbles(place: Path) -> bool:
        if place.name == "a.mp4":
            raise PermissionError(13, "Permission denied")
        return is_file(place)

    monkeypatch.setattr(Path, "is_file", stumbles)
    assert found(path) == moved
