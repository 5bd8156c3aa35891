"""What a person does on the page for the same accuracy, with one film and with two.

A scripted person in a real browser begins with a draft, takes keyframes of it, and puts joints of
all limbs where the first film shows them, 2 px off, which says nothing of depth; or has *Fit pose*
place the body, by both films where there are two. Counted are keys, clicks and drags.
"""

from __future__ import annotations

import shutil
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from playwright.sync_api import Page, sync_playwright

from bench.films.man import BESIDE, FIRST, Man, about_hips, quietly
from bench.films.without_a_hand import joints_of_session
from bench.keeping import DATA
from bench.table import Report
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from tests.app.serving import Keypose
from tests.browser.chromium import ARGUMENTS, find
from tests.browser.interaction import drag, section, settled, spot, until

PARTS: Final[Mapping[str, str]] = {
    "elbow": "forearm",
    "wrist": "hand",
    "knee": "shin",
    "ankle": "foot",
}
"""By joint the part that begins there, by whose handle it is dragged."""
SIGMA_PX: Final = 2.0
"""How far off a person sees a joint."""
LONGEST_S: Final = 300.0


@dataclass(frozen=True)
class Plan:
    """How a person works.  films: how many.  apart: frames between keyframes.  places: whether
    joints are dragged to where the first film shows them; else the pose is fitted."""

    films: int
    apart: int
    places: bool

    @property
    def name(self) -> str:
        how = "joints placed by hand" if self.places else "Fit pose"
        return f"{self.films} film{'s' * (self.films > 1)}, a keyframe every {self.apart}, {how}"


PLANS: Final = (
    Plan(1, 33, places=False),
    Plan(1, 33, places=True),
    Plan(1, 11, places=True),
    Plan(2, 33, places=False),
    Plan(2, 11, places=False),
)


@dataclass
class Hand:
    """A person at a page, whose actions are counted."""

    page: Page
    rng: np.random.Generator
    presses: int = 0
    drags: int = 0

    def press(self, key: str) -> None:
        self.presses += 1
        self.page.keyboard.press(key)
        self._rested()

    def go(self, frame: int) -> None:
        """By a click into the frame's box, and its number."""
        self.presses += 1
        box = self.page.locator(".fbox input")
        box.click()
        box.fill(str(frame))
        box.press("Enter")
        until(lambda: section(self.page, "view.frame") == frame, f"frame {frame}")
        self.page.evaluate("document.activeElement.blur()")

    def place(self, joint: str, uv: Array) -> None:
        """Drag a joint to where the picture shows it."""
        side, kind = joint.split("_")
        start = spot(self.page, f"{side}_{PARTS[kind]}")
        seen_uv = (uv + self.rng.normal(0.0, SIGMA_PX, 2)).tolist()
        end = self.page.evaluate(
            """(uv) => {
              const view = window.keypose.view('main');
              const [x, y] = view.fromView(uv);
              const box = view.el.getBoundingClientRect();
              return [box.left + x, box.top + y];
            }""",
            seen_uv,
        )
        self.drags += 1
        drag(self.page, start, (end[0], end[1]))
        self._rested()

    def _rested(self) -> None:
        """All that was begun is done."""
        settled(self.page)
        until(lambda: section(self.page, "job.state") != "running", "the work", LONGEST_S)


def counted(report: Report, man: Man, folder: Path) -> None:
    """Actions and error of every way of working."""
    path = find()
    if path is None:
        report.note("what a person does is not counted: there is no Chromium here")
        return
    table = report.table(
        "on the page, from a draft", "keyframes", "presses", "drags", "about hips mm"
    )
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=list(ARGUMENTS))
        for number, plan in enumerate(PLANS):
            session = _begun(folder / f"effort-{number}", plan.films)
            page = browser.new_page(viewport={"width": 1366, "height": 768})
            hand, keyframes = _worked(page, session, man, plan, folder)
            page.close()
            table.row(plan.name, keyframes, hand.presses, hand.drags, _error_mm(man, session))
        browser.close()


def _begun(folder: Path, films: int) -> Path:
    """A session of the first film with a draft of it, and with the other one."""
    folder.mkdir()
    paths = [DATA / "several" / f"single_cam0{number}.mp4" for number in (FIRST, BESIDE)]
    copies = [Path(shutil.copy(path, folder)) for path in paths]
    quietly("draft", str(copies[0]), "--out", str(folder))
    if films > 1:
        quietly("add-film", str(folder), str(copies[1]))
    return folder / "session.json"


def _worked(page: Page, session: Path, man: Man, plan: Plan, folder: Path) -> tuple[Hand, int]:
    """The person's work, and how many keyframes came of it."""
    keypose = Keypose(str(session), "--workspace", str(folder / "workspace"))
    hand = Hand(page, np.random.default_rng(7))
    try:
        page.goto(keypose.address)
        page.wait_for_selector("#mhead")
        page.keyboard.press("Escape")
        for frame in range(0, 100, plan.apart):
            hand.go(frame)
            hand.press("k")
            if plan.places:
                _place_joints(hand, man, frame)
            else:
                hand.press("f")
        hand.press("t")
        until(lambda: _is_tracked(page), "the motion", LONGEST_S)
        count = len(section(page, "keys.frames"))
    finally:
        code, words = keypose.end()
    assert code == 0, words
    return hand, count


def _is_tracked(page: Page) -> bool:
    states = [segment["state"] for segment in section(page, "segments")]
    is_idle = section(page, "job.state") != "running"
    return is_idle and bool(states) and not set(states) & {"none", "outdated", "waiting"}


def _place_joints(hand: Hand, man: Man, frame: int) -> None:
    uv = man.views[FIRST].camera.project(man.joints[frame])
    for number, joint in enumerate(JOINTS):
        if joint.split("_")[1] in PARTS:
            hand.place(joint, uv[number])


def _error_mm(man: Man, session: Path) -> float:
    made = joints_of_session(session)
    truth = man.truth[made.first_frame :][: len(made.joints)]
    off = np.linalg.norm(about_hips(made.joints) - about_hips(truth), axis=-1)
    return 1000 * float(off.mean())
