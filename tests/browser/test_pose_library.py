"""The library of poses as a person uses it."""

from __future__ import annotations

import pytest

from tests.browser.interaction import screen, settled, themed, until, until_state
from tests.browser.shared import Desk

OWN = True
"""Its server is its own."""
SIZE = (1440, 900)


def test_poses_are_kept_named_inserted_where_the_body_stands_and_deleted(shared: Desk) -> None:
    shared.fresh()
    page, visitor = shared.page, shared.visitor
    library = page.get_by_role("region", name="Pose library")
    library.get_by_text("adds the pose of this frame").wait_for()
    screen(page, "pose-library-empty")
    for count, frame in enumerate((0, 24, 48, 72), start=1):
        visitor.do(do="go", frame=frame)
        shared.agreed("view")
        library.get_by_role("button", name="Keep in the pose library").click()
        until_state(page, "poses.length", lambda now, count=count: now == count)
    name = library.get_by_label("Name of Pose 2")
    name.fill("Stride")
    name.press("Enter")
    until_state(page, "poses[1].name", lambda now: now == "Stride")
    visitor.do(do="go", frame=30)
    shared.agreed("view")
    shared.agreed("pose")
    root = shared.served["pose"]["root"]
    library.get_by_role("button", name="Insert Stride", exact=True).click()
    until_state(page, "undo.undo", lambda step: step == "insert the pose Stride")
    inserted = shared.agreed("pose")
    assert inserted["root"] == root
    library.get_by_role("button", name="Insert Stride", exact=True).hover()
    settled(page)
    screen(page, "pose-library")
    themed(page, "light")
    screen(page, "pose-library-light")
    themed(page, "dark")
    visitor.do(do="go", frame=24)
    until(lambda: shared.agreed("view")["frame"] == 24)
    keyed = shared.agreed("pose")["angles"]["left_shin"]
    assert inserted["angles"]["left_shin"] == pytest.approx(keyed, abs=0.01)
    library.get_by_role("button", name="Delete Stride").click()
    until_state(page, "poses.length", lambda now: now == 3)
    page.get_by_role("button", name="Undo", exact=True).last.click()
    until_state(page, "poses[1].name", lambda now: now == "Stride")
