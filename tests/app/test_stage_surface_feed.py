"""When observed surfaces are looked at: the newest wish counts; none stands where it is wrong."""

from __future__ import annotations

import asyncio
import shutil
import threading
from collections.abc import Callable, Coroutine, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from app.editor.state import EditorState
from app.library import Library
from app.opening import Workpiece, edit_state, open_workpiece
from app.outlook import Outlook, SurfaceSeen
from app.serving.surfaces import Surfaces
from app.stage.observed import Observed, Sight
from app.stage.skin import skin
from tests.app.editor.desk import after
from tracker.surface.picture import SurfaceVideo

SAMPLE = Path(__file__).resolve().parents[2] / "sample_videos" / "arms"
LAST = 18


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The arms, with one step that cannot be read."""
    place = tmp_path_factory.mktemp("feed") / "arms"
    shutil.copytree(SAMPLE, place)
    (place / "meshes" / "step_0004.ply").write_bytes(b"")
    return place


@pytest.fixture(scope="module")
def piece(folder: Path) -> Iterator[Workpiece]:
    made = open_workpiece(folder / "session.json", lambda path: path)
    yield made
    made.video.close()


@pytest.fixture
def edit(piece: Workpiece) -> EditorState:
    return edit_state(piece)[0]


@dataclass
class Views:
    """What the views were told: skins, None for nothing, and what was seen."""

    skins: list[bytes | None] = field(default_factory=list)
    seen: list[SurfaceSeen] = field(default_factory=list)


def looking(work: Callable[[Surfaces, Views], Coroutine[Any, Any, None]]) -> Views:
    """Do it on a loop with a Surfaces of its own."""
    views = Views()

    async def run() -> None:
        loop = asyncio.get_running_loop()
        surfaces = Surfaces(loop, views.skins.append, lambda: None, views.seen.append)
        await asyncio.wait_for(work(surfaces, views), 60)

    asyncio.run(run())
    return views


async def until(there: Callable[[], object]) -> None:
    while not there():
        await asyncio.sleep(0.01)


def test_of_many_frames_at_once_the_newest_is_looked_at(
    piece: Workpiece, edit: EditorState
) -> None:
    async def work(surfaces: Surfaces, views: Views) -> None:
        for frame in range(LAST + 1):
            surfaces.follow(piece, replace(edit, frame=frame))
        await until(lambda: views.seen)

    views = looking(work)
    assert [seen.frame for seen in views.seen] == [LAST]
    sight = Observed(piece).sight(edit, LAST)
    assert views.skins == [skin(sight.mesh, sight.colours)]


def test_what_stays_the_same_is_not_sent_again(piece: Workpiece, edit: EditorState) -> None:
    edit = replace(edit, frame=3)

    async def work(surfaces: Surfaces, views: Views) -> None:
        surfaces.follow(piece, edit)
        await until(lambda: views.seen)
        surfaces.follow(piece, after(edit, {"do": "root", "x": 0.2}))
        surfaces.follow(piece, after(edit, {"do": "display", "opacity": 0.2}))
        surfaces.follow(piece, after(edit, {"do": "display", "tint": "distance"}))
        await until(lambda: len(views.seen) > 1)
        surfaces.follow(
            piece, after(edit, {"do": "display", "tint": "distance"}, {"do": "root", "x": 0.2})
        )
        await until(lambda: len(views.seen) > 2)

    views = looking(work)
    assert len(set(views.skins)) == 3  # in clay; by the distance; by that of another pose


def test_a_step_that_cannot_be_used_leaves_nothing_and_says_why(
    piece: Workpiece, edit: EditorState
) -> None:
    async def work(surfaces: Surfaces, views: Views) -> None:
        surfaces.follow(piece, replace(edit, frame=4))
        await until(lambda: views.seen)

    views = looking(work)
    assert views.skins == [None]
    assert "step_0004.ply" in views.seen[0].problem
    assert views.seen[0].rims is not None  # of the model's own step


def test_a_surface_does_not_stand_where_the_body_has_long_gone_on(
    piece: Workpiece, edit: EditorState, monkeypatch: pytest.MonkeyPatch
) -> None:
    read, usual = threading.Event(), Observed.sight

    def slow(observed: Observed, state: EditorState, frame: int) -> Sight:
        assert frame == 0 or read.wait(60)
        return usual(observed, state, frame)

    monkeypatch.setattr(Observed, "sight", slow)

    async def work(surfaces: Surfaces, views: Views) -> None:
        surfaces.follow(piece, edit)
        await until(lambda: len(views.skins) == 1)
        surfaces.follow(piece, replace(edit, frame=7))
        await until(lambda: len(views.skins) == 2)
        assert views.skins[-1] is None
        read.set()
        await until(lambda: len(views.skins) == 3)
        assert views.skins[-1] is not None

    looking(work)


def test_another_session_takes_the_surface_away(piece: Workpiece, edit: EditorState) -> None:
    async def work(surfaces: Surfaces, views: Views) -> None:
        surfaces.follow(piece, edit)
        await until(lambda: views.seen)
        surfaces.follow(None, None)

    assert looking(work).skins[-1] is None


def pixels(content: bytes | None) -> np.ndarray[Any, Any]:
    assert content is not None
    picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    return picture.astype(float)


def test_the_large_picture_has_the_colours_too(piece: Workpiece, edit: EditorState) -> None:
    found: dict[str, np.ndarray[Any, Any]] = {}

    async def work(surfaces: Surfaces, _: Views) -> None:
        for tint in ("clay", "photo", "distance"):
            state = replace(after(edit, {"do": "display", "tint": tint}), frame=9)
            surfaces.follow(piece, state)
            found[tint] = pixels(await surfaces.jpeg(9, Outlook(edit=state)))
        found["none"] = pixels(await surfaces.jpeg(4, Outlook(edit=state)))

    looking(work)
    assert isinstance(piece.video, SurfaceVideo)
    height, width = piece.video.info.height, piece.video.info.width
    assert found["clay"].shape == (height, width, 3)
    for tint in ("photo", "distance"):
        redder = (found[tint] - found["clay"]) @ [0, -1, 1]
        assert (redder > 20).mean() > 0.002
    assert np.ptp(found["none"]) < 20  # the ground alone


# --- where they are chosen


def test_folders_of_meshes_and_glb_files_are_listed(tmp_path: Path) -> None:
    shutil.copytree(SAMPLE / "meshes", tmp_path / "home" / "run")
    (tmp_path / "home" / "man.glb").write_bytes(b"glTF")
    textured = tmp_path / "home" / "shots"
    textured.mkdir()
    for name in ("a.png", "b.png", "c.png", "lone.ply"):
        (textured / name).touch()
    listed = Library(tmp_path / "work", [tmp_path / "home"]).contents()["files"]
    kinds = {file["name"]: (file["kind"], file["count"]) for file in listed}
    assert kinds == {"run": ("meshes", 19), "man.glb": ("meshes", 0), "shots": ("images", 3)}


def test_an_animated_file_can_be_dropped(tmp_path: Path) -> None:
    library = Library(tmp_path / "work")
    with library.upload("man.glb", 4) as upload:
        upload.write(b"glTF")
        assert upload.finish() == "man.glb"
    assert library.find("upload", "man.glb").read_bytes() == b"glTF"
