"""What the page is told of a hold: its frames while dragged, and why its points are apart."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from keypose.app.editor.state import EditorState
from keypose.app.posing import opening_pose
from keypose.app.state.app_state import AppState
from keypose.app.store.sections import Sections, bond_values
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.session.schema import Session
from keypose.tracker.storage.results import Results
from tests.app.editor.desk import after
from tests.app.editor.test_bonds import HOLD, with_box
from tests.tracker.operations.test_bonds import SHAKE, shaking, tracked, with_keyframe_aside


def reported(edit: EditorState) -> dict[str, Any]:
    (bond,) = Sections().changed(AppState(edit=edit))["bonds"]
    assert isinstance(bond, dict)
    return bond


def edited(doc: Session) -> EditorState:
    return EditorState(
        doc=doc,
        skeleton=Skeleton.of(doc.subject.body),
        file_times_s=np.arange(doc.view.video.frame_count) / 30,
        opening=opening_pose(doc.subject.body, doc.view.camera, (0.0, -1.0, 0.0)),
    )


def test_a_hold_goes_along_while_its_end_is_dragged() -> None:
    sections, state = Sections(), after(with_box(), HOLD)
    sections.changed(AppState(edit=state))
    drag = {"do": "change_bond", "index": 0, "last": 40, "stroke": "bond-1"}
    dragged = after(state, drag)
    assert dragged.stroke is not None
    (bond,) = sections.changed(AppState(edit=dragged))["bonds"]
    assert bond["last"] == 40


def test_keyframes_of_both_keep_apart_what_should_meet() -> None:
    bond = reported(edited(with_keyframe_aside(shaking(SHAKE), 4)))
    assert (bond["cause"], bond["worst"], bond["apart_cm"]) == ("keyed", 4, 4.0)


def test_a_body_of_a_hold_that_has_no_keyframe_is_named() -> None:
    doc = shaking(SHAKE)
    doc = doc.with_body(doc.bodies[1].model_copy(update={"keyframes": (), "called": "Ball"}))
    bond = reported(edited(doc))
    assert (bond["cause"], bond["unposed"]) == ("unposed", "Ball")


@pytest.mark.parametrize(
    ("results", "cause"),
    [
        (Results(), "untracked"),
        (tracked(shaking(SHAKE), solve=False), "untracked"),
        (tracked(shaking(SHAKE)), "tracked"),
    ],
    ids=["not tracked", "not solved for in space", "up to date"],
)
def test_what_is_apart_waits_for_tracking_only_until_both_are_up_to_date(
    results: Results, cause: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bond_values, "apart_m", lambda *_: 0.08)
    bond = reported(edited(shaking(SHAKE)).with_results(results))
    assert (bond["cause"], bond["meet"], bond["apart_cm"]) == (cause, False, 8.0)
