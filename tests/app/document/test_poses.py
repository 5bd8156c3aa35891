"""The library of poses on the disk."""

from __future__ import annotations

from pathlib import Path

import pytest

from keypose.app.document.library.poses import MOST, PoseShelf
from keypose.app.editor.copied import Copied
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.shown import shown_pose
from keypose.app.render.pose_strokes import SIZE, PoseStroke, pose_strokes
from keypose.tracker.errors import KeyposeError
from tests.app.editor.desk import desk


def copied() -> Copied:
    return Copied.pose_of(desk().skeleton, shown_pose(desk()).pose)


def strokes() -> tuple[PoseStroke, ...]:
    return pose_strokes(desk().skeleton, shown_pose(desk()).pose)


@pytest.fixture
def shelf(tmp_path: Path) -> PoseShelf:
    return PoseShelf(tmp_path / "workspace" / "poses.json")


def test_a_pose_is_there_for_the_next_program_as_it_was_kept(
    shelf: PoseShelf, tmp_path: Path
) -> None:
    assert shelf.poses() == ()
    shelf.keep("Sitting", copied(), strokes())
    (kept,) = PoseShelf(tmp_path / "workspace" / "poses.json").poses()
    assert (kept.name, kept.copied, kept.strokes) == ("Sitting", copied(), strokes())


def test_a_pose_is_renamed_deleted_and_put_back_where_it_stood(shelf: PoseShelf) -> None:
    first, second = (shelf.keep(name, copied(), ()) for name in ("One", "Two"))
    shelf.rename(second.id, "Other")
    place, gone = shelf.delete(first.id)
    assert [pose.name for pose in shelf.poses()] == ["Other"]
    shelf.put_back(place, gone)
    assert [pose.name for pose in shelf.poses()] == ["One", "Other"]
    with pytest.raises(ActionRefused, match="not in the library any more"):
        shelf.delete("0" * 12)


def test_a_damaged_library_is_left_as_it_is(shelf: PoseShelf, tmp_path: Path) -> None:
    shelf.keep("One", copied(), ())
    file = tmp_path / "workspace" / "poses.json"
    damaged = file.read_bytes()[:-20]
    file.write_bytes(damaged)
    with pytest.raises(KeyposeError, match="cannot be read"):
        shelf.keep("Two", copied(), ())
    assert file.read_bytes() == damaged


def test_the_library_takes_no_more_than_it_can_show(
    shelf: PoseShelf, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("keypose.app.document.library.poses.MOST", 2)
    for name in ("One", "Two"):
        shelf.keep(name, copied(), ())
    with pytest.raises(ActionRefused, match="holds 2 poses"):
        shelf.keep("Three", copied(), ())
    assert MOST == 200


def test_the_picture_has_a_stroke_for_every_part_within_its_field() -> None:
    drawn = strokes()
    assert len(drawn) == desk().skeleton.part_count
    for stroke in drawn:
        for value in (stroke.x0, stroke.y0, stroke.x1, stroke.y1):
            assert -1 <= value <= SIZE + 1
        assert 0 < stroke.width < SIZE / 2
    assert {stroke.side for stroke in drawn} == {"L", "R", "C"}
