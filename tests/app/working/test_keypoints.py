"""The keypoints of the present frame: found before, with what a person said of them."""

from __future__ import annotations

import asyncio
import hashlib
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.store.sections import Sections
from keypose.app.store.store import Store
from keypose.app.working import keypoints as finding
from keypose.app.working import queue
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.session import Session
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.networks import add_own
from keypose.tracker.storage.sidecars import save_keypoints
from tests.app.working.test_fitting import Worker
from tests.scenes import StoreDesk, at_desk, sample
from tests.tracker.keypoints import tiny_networks as tiny

NAMES = (*JOINTS, "nose", "left_pinky")
WRIST = JOINTS.index("left_wrist")


@pytest.fixture(autouse=True)
def _alone(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No worker, and nothing kept from an earlier day."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(queue, "JobRunner", Worker)


def found(first: int, last: int, u: float) -> Keypoints:
    """Everything at (u, frame)."""
    frames = np.arange(first, last + 1.0)
    uv = np.stack([np.full_like(frames, u), frames], axis=-1)[:, None].repeat(len(NAMES), axis=1)
    sure = np.full(uv.shape[:2], 0.9)
    sure[:, WRIST] = 0.58
    return Keypoints(first, NAMES, uv, sure)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A session with a draft's keypoints in frames 0 to 40, tracking by keypoints."""
    path = sample(tmp_path)
    session = load_session(path)
    settings = session.settings.model_copy(update={"cues": ("brightness", "keypoints")})
    session = session.changed({"settings": settings})
    save_session(save_keypoints(session, path, found(0, 40, 5.0), "draft", network="n"), path)
    return path


class Desk(StoreDesk):
    def __init__(self, store: Store) -> None:
        super().__init__(store)
        self.sections = Sections()

    async def shown(self, frame: int) -> Any:
        """The section of a frame, once all that is read for it has been."""
        self.do({"do": "go", "frame": frame})
        await asyncio.sleep(0)
        while (reading := self.store._keypoints._reading) is not None:
            await reading
            await asyncio.sleep(0)
        return Sections().changed(self.store.app_state)["keypoints"]


@pytest.fixture
async def desk(path: Path) -> AsyncIterator[Desk]:
    async with at_desk(path, Desk) as made:
        yield made


def point(section: Any, joint: str = "left_wrist") -> Any:
    return next(each for each in section["points"] if each["joint"] == joint)


async def test_those_of_a_draft_are_reported_frame_by_frame_as_far_as_the_body_has_them(
    desk: Desk,
) -> None:
    shown = await desk.shown(7)
    assert shown["frame"] == 7
    assert len(shown["points"]) == 13  # fingers are not compared with anything
    wrist = {"joint": "left_wrist", "label": "Left wrist", "at": [5.0, 7.0]}
    assert point(shown) == {**wrist, "sure": 0.58, "state": "found"}
    assert await desk.shown(60) is None


async def test_what_tracking_found_in_a_segment_goes_first(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[Any] = []

    def kept(doc: Session, span: tuple[int, int], drafted: Keypoints | None) -> Keypoints | None:
        assert drafted is not None
        assert drafted.last_frame == 40, "those of the session's file"
        asked.append(span)
        return found(*span, 33.0) if span == (24, 48) else None

    monkeypatch.setattr(finding, "found_before", kept)
    async with at_desk(path, Desk) as desk:
        assert point(await desk.shown(7))["at"] == [5.0, 7.0]
        assert point(await desk.shown(30))["at"] == [33.0, 30.0]
        assert point(await desk.shown(45))["at"] == [33.0, 45.0]
        await desk.shown(7)
        assert asked.count((24, 48)) == 1
        before = asked.count((0, 24))
        desk.store._keypoints.tracked()
        await desk.shown(8)
        assert asked.count((0, 24)) == before + 1  # it may be there now


async def test_what_a_person_said_is_reported_at_once_and_where_it_was_found_is_not_lost(
    desk: Desk,
) -> None:
    await desk.shown(7)
    wrist = {"frame": 7, "joint": "left_wrist"}
    desk.do({"do": "correct_keypoint", **wrist, "at": [50, 60], "stroke": "ring"})
    moved = point(await desk.shown(7))
    assert (moved["at"], moved["sure"], moved["state"]) == ([50.0, 60.0], 1.0, "corrected")
    desk.do({"do": "ignore_keypoint", **wrist})
    hidden = point(await desk.shown(7))
    assert (hidden["at"], hidden["sure"], hidden["state"]) == ([5.0, 7.0], 0.0, "ignored")
    desk.do({"do": "restore_keypoint", **wrist})
    assert point(await desk.shown(7))["state"] == "found"


async def test_a_file_that_is_gone_shows_nothing_and_breaks_nothing(path: Path) -> None:
    for file in path.parent.glob("keypoints-*.npz"):
        file.unlink()
    async with at_desk(path, Desk) as desk:
        assert await desk.shown(7) is None


async def test_cues_and_networks_say_what_can_be_chosen_and_why_not(desk: Desk) -> None:
    def reported(name: str) -> Any:
        return {each["id"]: each for each in Sections().changed(desk.store.app_state)[name]}

    desk.do({"do": "settings", "network": "heavy"})
    cue = reported("cues")["keypoints"]
    assert (cue["on"], cue["off"]) == (True, "")
    thunder, full, heavy = reported("networks").values()
    assert (thunder["label"], thunder["remedy"]) == ("MoveNet Thunder + BlazePose", "")
    assert (full["chosen"], full["remedy"]) == (False, "")
    assert (heavy["chosen"], heavy["remedy"]) == (True, "keypose models add heavy")
    desk.do({"do": "settings", "method": "paper"})
    assert reported("cues")["keypoints"]["off"] == "Not in the published method"


async def test_networks_of_ones_own_can_be_chosen_and_a_missing_one_says_how_to_add_it(
    desk: Desk, tmp_path: Path
) -> None:
    def networks() -> Any:
        reported = Sections().changed(desk.store.app_state)["networks"]
        return {each["id"]: (each["label"], each["chosen"], each["remedy"]) for each in reported}

    again = "keypose models add mine --from FILE --sha256 DIGEST"
    desk.do({"do": "settings", "network": "mine"})
    assert networks()["mine"] == ("mine", True, again)
    assert await desk.shown(7) is not None
    content = tiny.simcc()
    (tmp_path / "file").write_bytes(content)
    model = add_own("mine", tmp_path / "file", hashlib.sha256(content).hexdigest())
    assert networks()["mine"] == ("mine + BlazePose", True, "")
    model.path.unlink()
    assert networks()["mine"] == ("mine + BlazePose", True, again)
    desk.do({"do": "settings", "network": "../mine"})
    assert desk.doc.settings.network == "mine"


def test_a_file_that_brings_about_a_fault_of_ours_is_as_if_it_were_not_there_and_logged(
    capsys: pytest.CaptureFixture[str],
) -> None:
    def faulty() -> None:
        raise ZeroDivisionError

    assert finding._or_none(faulty) is None
    assert "ZeroDivisionError" in capsys.readouterr().err
