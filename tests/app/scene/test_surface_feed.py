"""When observed surfaces are looked at: the newest wish counts; none stands where it is wrong."""

from __future__ import annotations

import asyncio
import shutil
import threading
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from keypose.app.document.library import Library
from keypose.app.document.open import OpenSession, edit_state, open_for_editing
from keypose.app.editor.state import EditorState
from keypose.app.render.surfaces import SurfaceLayer
from keypose.app.scene.observed import Outdated, SurfaceViews, skin
from keypose.app.server.surfaces import Surfaces
from keypose.app.state.app_state import AppState, SurfaceSeen
from keypose.tracker.errors import VideoError
from keypose.tracker.session.schema import Session
from keypose.tracker.surface import source
from keypose.tracker.surface.picture import SurfaceVideo
from tests.app.editor.desk import after

SAMPLE = Path(__file__).resolve().parents[3] / "sample_videos" / "arms"
LAST = 18


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The arms, with one step that cannot be read."""
    place = tmp_path_factory.mktemp("feed") / "arms"
    shutil.copytree(SAMPLE, place)
    (place / "meshes" / "step_0004.ply").write_bytes(b"")
    return place


@pytest.fixture(scope="module")
def piece(folder: Path) -> Iterator[OpenSession]:
    made = open_for_editing(folder / "session.json", lambda path: path)
    yield made
    made.video.close()


@pytest.fixture
def edit(piece: OpenSession) -> EditorState:
    return edit_state(piece)[0]


def observe(state: EditorState, **how: Any) -> EditorState:
    """The surfaces read otherwise, whatever the page offers."""
    assert state.doc.view.surface is not None
    surface = state.doc.view.surface.model_copy(update=how)
    return replace(state, doc=state.doc.changed({"surface": surface}))


@dataclass
class Views:
    """What the views were told: skins, None for nothing, and what was seen."""

    skins: list[bytes | None] = field(default_factory=list)
    seen: list[SurfaceSeen] = field(default_factory=list)
    unusable: list[str] = field(default_factory=list)


@asynccontextmanager
async def looking() -> AsyncIterator[tuple[Surfaces, Views]]:
    """Surfaces of one's own, and what they tell."""
    views = Views()
    surfaces = Surfaces(
        asyncio.get_running_loop(), views.skins.append, lambda: None, views.seen.append,
        views.unusable.append,
    )  # fmt: skip
    async with asyncio.timeout(60):
        yield surfaces, views


async def until(there: Callable[[], object]) -> None:
    while not there():
        await asyncio.sleep(0.01)


async def test_of_many_frames_at_once_the_newest_is_looked_at(
    piece: OpenSession, edit: EditorState
) -> None:
    async with looking() as (surfaces, views):
        for frame in range(LAST + 1):
            surfaces.follow(piece, replace(edit, frame=frame))
        await until(lambda: views.seen)
    assert [seen.frame for seen in views.seen] == [LAST]
    surface = SurfaceViews(piece).layer(edit, LAST)
    assert views.skins == [skin(surface.mesh, surface.colours)]


async def test_what_stays_the_same_is_not_sent_again(piece: OpenSession, edit: EditorState) -> None:
    edit = replace(edit, frame=3)
    async with looking() as (surfaces, views):
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
    assert len(set(views.skins)) == 3  # in clay; by the distance; by that of another pose


async def test_a_step_that_cannot_be_used_leaves_nothing_and_says_why(
    piece: OpenSession, edit: EditorState
) -> None:
    async with looking() as (surfaces, views):
        surfaces.follow(piece, replace(edit, frame=4))
        await until(lambda: views.seen)
    assert views.skins == [None]
    assert "step_0004.ply" in views.seen[0].problem
    assert views.seen[0].rims is not None  # of the model's own step


async def test_a_surface_does_not_stand_where_the_body_has_long_gone_on(
    piece: OpenSession, edit: EditorState, monkeypatch: pytest.MonkeyPatch
) -> None:
    read, usual = threading.Event(), SurfaceViews.layer

    def slow(observed: SurfaceViews, state: EditorState, frame: int) -> SurfaceLayer:
        assert frame == 0 or read.wait(60)
        return usual(observed, state, frame)

    monkeypatch.setattr(SurfaceViews, "layer", slow)
    async with looking() as (surfaces, views):
        surfaces.follow(piece, edit)
        await until(lambda: len(views.skins) == 1)
        surfaces.follow(piece, replace(edit, frame=7))
        await until(lambda: len(views.skins) == 2)
        assert views.skins[-1] is None
        read.set()
        await until(lambda: len(views.skins) == 3)
        assert views.skins[-1] is not None


async def test_another_session_takes_the_surface_away(
    piece: OpenSession, edit: EditorState
) -> None:
    async with looking() as (surfaces, views):
        surfaces.follow(piece, edit)
        await until(lambda: views.seen)
        surfaces.follow(None, None)
    assert views.skins[-1] is None


def pixels(content: bytes | None) -> np.ndarray[Any, Any]:
    assert content is not None
    picture = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_COLOR)
    assert picture is not None
    return picture.astype(float)


async def test_the_large_picture_has_the_colours_too(piece: OpenSession, edit: EditorState) -> None:
    found: dict[str, np.ndarray[Any, Any]] = {}
    async with looking() as (surfaces, _):
        for tint in ("clay", "photo", "distance"):
            state = replace(after(edit, {"do": "display", "tint": tint}), frame=9)
            surfaces.follow(piece, state)
            found[tint] = pixels(await surfaces.jpeg(9, AppState(edit=state)))
        found["none"] = pixels(await surfaces.jpeg(4, AppState(edit=state)))
    assert isinstance(piece.video, SurfaceVideo)
    height, width = piece.video.info.height, piece.video.info.width
    assert found["clay"].shape == (height, width, 3)
    for tint in ("photo", "distance"):
        redder = (found[tint] - found["clay"]) @ [0, -1, 1]
        assert (redder > 20).mean() > 0.002
    assert np.ptp(found["none"]) < 20  # the ground alone


async def test_a_rate_reaches_pictures_and_what_is_made_of_them(
    piece: OpenSession, edit: EditorState
) -> None:
    faster = observe(edit, fps=50)
    async with looking() as (surfaces, _):
        surfaces.follow(piece, edit)
        usual = await surfaces.jpeg(9, AppState(edit=edit))
        surfaces.follow(piece, faster)
        video = await surfaces.video(faster)
        assert video is not None
        assert video.info.fps == 50
        assert await surfaces.jpeg(9, AppState(edit=faster)) == usual


# --- surfaces that are read anew


def test_what_asks_for_an_older_reading_does_not_bring_it_back(
    piece: OpenSession, edit: EditorState
) -> None:
    older, newer = observe(edit, units="dm"), observe(edit, units="mm")
    observed = SurfaceViews(piece)
    for state in (older, newer):
        observed.follow(state.settled)
        video = observed.video(state.settled)
    for ask in (observed.rims, lambda state: observed.layer(state, 0)):
        with pytest.raises(Outdated):
            ask(older)
    assert observed.video(newer.settled) is video
    assert not video.is_closed
    observed.close()
    assert video.is_closed
    with pytest.raises(Outdated):
        observed.video(newer.settled)


async def test_a_reading_that_is_undone_and_done_again_is_still_seen(
    piece: OpenSession, edit: EditorState
) -> None:
    moved, other = observe(edit, p_camera_surface=(0.1, 0, 2.2)), observe(edit, units="mm")
    async with looking() as (surfaces, _):
        surfaces.follow(piece, moved)
        await surfaces.jpeg(9, AppState(edit=moved))
        surfaces.follow(piece, other)
        await surfaces.video(other)
        surfaces.follow(piece, moved)
        assert np.ptp(pixels(await surfaces.jpeg(10, AppState(edit=moved)))) > 50


async def test_the_views_see_the_newest_reading_though_an_older_look_was_under_way(
    piece: OpenSession, edit: EditorState, monkeypatch: pytest.MonkeyPatch
) -> None:
    older, newer = observe(edit, units="mm"), observe(edit, p_camera_surface=(0.3, 0, 2.2))
    under_way, go_on, usual = threading.Event(), threading.Event(), SurfaceViews.rims

    def slow(observed: SurfaceViews, state: EditorState) -> int:
        if state is older:
            under_way.set()
            assert go_on.wait(60)
        return usual(observed, state)

    monkeypatch.setattr(SurfaceViews, "rims", slow)
    async with looking() as (surfaces, views):
        surfaces.follow(piece, older)
        await until(under_way.is_set)
        surfaces.follow(piece, newer)
        picture = asyncio.create_task(surfaces.jpeg(9, AppState(edit=newer)))
        assert np.ptp(pixels(await picture)) > 50
        go_on.set()
        await until(lambda: views.seen)
        assert np.ptp(pixels(await surfaces.jpeg(10, AppState(edit=newer)))) > 50
    surface = SurfaceViews(piece).layer(edit, 0)
    assert [seen.problem for seen in views.seen] == [""]
    assert views.seen[0].middle is not None
    assert views.seen[0].middle[0] > surface.mesh.vertices[:, 0].mean() + 0.05


async def test_of_meshes_that_have_been_closed_no_picture_is_made(folder: Path) -> None:
    opened = open_for_editing(folder / "session.json", lambda path: path)
    edit = edit_state(opened)[0]
    async with looking() as (surfaces, _):
        surfaces.follow(opened, edit)
        await surfaces.jpeg(9, AppState(edit=edit))
        opened.video.close()
        with pytest.raises(VideoError, match="closed"):
            await surfaces.jpeg(10, AppState(edit=edit))


async def test_after_a_fault_the_next_wish_is_looked_at(
    piece: OpenSession, edit: EditorState, monkeypatch: pytest.MonkeyPatch
) -> None:
    usual = SurfaceViews.layer

    def faulty(observed: SurfaceViews, state: EditorState, frame: int) -> SurfaceLayer:
        if frame == 3:
            raise OSError
        return usual(observed, state, frame)

    monkeypatch.setattr(SurfaceViews, "layer", faulty)
    async with looking() as (surfaces, views):
        surfaces.follow(piece, replace(edit, frame=3))
        await until(lambda: views.skins)
        surfaces.follow(piece, replace(edit, frame=5))
        await until(lambda: views.seen)
    assert views.skins[0] is None
    assert views.skins[1] is not None


async def test_the_page_goes_on_while_surfaces_are_read(
    piece: OpenSession, edit: EditorState, monkeypatch: pytest.MonkeyPatch
) -> None:
    read, usual = threading.Event(), SurfaceViews.video

    def slow(observed: SurfaceViews, doc: Session) -> SurfaceVideo:
        assert read.wait(20), "nothing else was done meanwhile"
        return usual(observed, doc)

    async with looking() as (surfaces, _):
        surfaces.follow(piece, edit)
        monkeypatch.setattr(SurfaceViews, "video", slow)
        asked = asyncio.create_task(surfaces.video(edit))
        await asyncio.sleep(0)
        read.set()
        assert await asked is piece.video


# --- where they are chosen


def test_folders_of_meshes_are_listed_and_single_ones_are_not(tmp_path: Path) -> None:
    shutil.copytree(SAMPLE / "meshes", tmp_path / "home" / "run")
    (tmp_path / "home" / "man.glb").write_bytes(b"glTF")
    textured = tmp_path / "home" / "shots"
    textured.mkdir()
    for name in ("a.png", "b.png", "c.png", "d.png", "e.png", "lone.ply"):
        (textured / name).touch()
    listed = Library(tmp_path / "work", [tmp_path / "home"]).contents()["files"]
    kinds = {file["name"]: (file["kind"], file["count"]) for file in listed}
    assert kinds == {"run": ("meshes", 19), "shots": ("images", 5)}


async def test_steps_that_cannot_be_used_are_reported_once_before_they_are_met(
    piece: OpenSession, edit: EditorState
) -> None:
    async with looking() as (surfaces, views):
        surfaces.follow(piece, edit)
        await until(lambda: views.unusable)
        surfaces.follow(piece, after(edit, {"do": "go", "frame": 9}))
        await until(lambda: views.seen[-1].frame == 9)
    assert views.unusable == ['Step 4 ("step_0004.ply") is empty: export it again.']
    assert all(seen.frame != 4 for seen in views.seen)


def test_of_meshes_that_are_closed_meanwhile_nothing_is_asked_any_more(folder: Path) -> None:
    """The process that reads is not started anew."""
    opened = open_for_editing(folder / "session.json", lambda path: path)
    assert isinstance(opened.video, SurfaceVideo)
    opened.video.close()
    assert SurfaceViews(opened).unusable() == ""
    assert opened.video.steps.sequence._reader._child is None


def test_steps_that_cannot_be_used_are_looked_for_for_a_while_only(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opened = open_for_editing(folder / "session.json", lambda path: path)
    assert isinstance(opened.video, SurfaceVideo)
    with opened.video:
        assert "step_0004.ply" in SurfaceViews(opened).unusable()
        monkeypatch.setattr(source, "CHECKED_S", -1.0)
        assert SurfaceViews(opened).unusable() == ""
