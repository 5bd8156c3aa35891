"""Kept poses as the page works with them."""

from __future__ import annotations

import asyncio
from pathlib import Path

import numpy as np
import pytest
from pydantic import ValidationError

from keypose.app.document.library.poses import KeptPose
from keypose.app.editor.actions import DeletePose, InsertPose, KeepPose, RenamePose, RestorePose
from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.editor.update import update
from keypose.app.posing import mirror_pose
from keypose.app.state.app_state import AppState
from keypose.app.store.sections import Sections
from keypose.app.store.session_manager import PoseLibrary
from tests.app.editor.desk import after, desk


def kept_in(folder: Path, *names: str) -> tuple[PoseLibrary, list[tuple[KeptPose, ...]]]:
    """A library with these poses, and what the page was shown of it, change by change."""
    shown: list[tuple[KeptPose, ...]] = []
    library = PoseLibrary(folder, shown.append)

    async def keep() -> None:
        for name in names:
            await library.change(KeepPose(name=name), desk())

    asyncio.run(keep())
    return library, shown


def inserted(library: PoseLibrary, id: str, *, mirrored: bool = False) -> EditorState:
    state = after(desk(), {"do": "go", "frame": 36})
    return update(state, library.inserting(InsertPose(id=id, mirrored=mirrored)))


def test_a_kept_pose_is_inserted_where_the_body_stands_under_its_name(tmp_path: Path) -> None:
    library, shown = kept_in(tmp_path, "Stride")
    state = inserted(library, shown[-1][0].id)
    pose, kept = shown_pose(state).pose, shown_pose(desk()).pose
    np.testing.assert_allclose(pose.Rs_parent_part, kept.Rs_parent_part, atol=1e-9)
    here = shown_pose(after(desk(), {"do": "go", "frame": 36})).pose
    np.testing.assert_allclose(pose.p_camera_root, here.p_camera_root)
    assert state.history.past[-1].label == "insert the pose Stride"


def test_inserted_mirrored_left_and_right_are_exchanged(tmp_path: Path) -> None:
    library, shown = kept_in(tmp_path, "Stride")
    pose = shown_pose(inserted(library, shown[-1][0].id, mirrored=True)).pose
    kept = mirror_pose(desk().skeleton, shown_pose(desk()).pose)
    np.testing.assert_allclose(pose.Rs_parent_part, kept.Rs_parent_part, atol=1e-9)


def test_poses_are_renamed_deleted_and_had_back(tmp_path: Path) -> None:
    library, shown = kept_in(tmp_path, "One", "Two")
    first, second = shown[-1]

    async def change() -> None:
        await library.change(RenamePose(id=second.id, name="Other"), None)
        await library.change(DeletePose(id=first.id), None)
        await library.change(RestorePose(id=first.id), None)
        await library.change(RestorePose(id=first.id), None)  # pressed twice

    asyncio.run(change())
    names = [[pose.name for pose in poses] for poses in shown]
    assert names == [
        ["One"],
        ["One", "Two"],
        ["One", "Other"],
        ["Other"],
        ["One", "Other"],
        ["One", "Other"],
    ]
    with pytest.raises(ActionRefused, match="not in the library any more"):
        library.inserting(InsertPose(id="0" * 12))


@pytest.mark.parametrize("name", ["", "   ", "a\nb", "x" * 61])
def test_a_name_that_cannot_be_read_on_one_line_is_refused(name: str) -> None:
    with pytest.raises(ValidationError):
        KeepPose(name=name)


def test_another_program_of_the_workspace_reads_what_was_kept(tmp_path: Path) -> None:
    kept_in(tmp_path, "One")
    library, shown = kept_in(tmp_path)
    asyncio.run(library.read())
    assert [pose.name for pose in shown[-1]] == ["One"]


def test_the_page_receives_each_pose_its_picture_and_whether_it_fits(tmp_path: Path) -> None:
    _, shown = kept_in(tmp_path, "One")
    (reported,) = Sections().changed(AppState(edit=desk(), poses=shown[-1]))["poses"]
    assert (reported["name"], reported["fits"]) == ("One", True)
    assert len(reported["strokes"]) == desk().skeleton.part_count
    assert reported["strokes"][0][0] in "LRC"
