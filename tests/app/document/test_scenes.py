"""Several bodies and several cameras in one file: each body is tracked by itself, and kept."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from keypose.app.cli.main import main
from keypose.tracker.errors import one_sentence
from keypose.tracker.session import Session
from keypose.tracker.session.bodies import ViewKeypoints
from keypose.tracker.session.references import KeypointFile
from keypose.tracker.storage.edit_history import Moment, base_record, edit_record, mark_of
from keypose.tracker.storage.files import journal_path, load_session, open_session, save_session
from keypose.tracker.storage.journal import lines
from keypose.tracker.storage.tracks import load_trajectory
from tests.app.bodies_cases import of_two
from tests.scenes import sample
from tests.tracker import session_cases as cases


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = sample(tmp_path, "box")
    save_session(of_two(load_session(path)), path)
    return path


def test_every_body_of_a_file_is_tracked_by_itself(path: Path) -> None:
    assert main(["track", str(path)]) == 0
    session = load_session(path)
    assert [body.id for body in session.bodies] == ["body", "second"]
    first, second = (load_trajectory(session.about(body.id), path) for body in session.bodies)
    names = {body.results.tracks for body in session.bodies if body.results is not None}
    assert len(names) == 2
    for one, other in ((first, session.bodies[0]), (second, session.bodies[1])):
        for keyframe in other.keyframes:
            np.testing.assert_allclose(one.pose(keyframe.frame).p_camera_root, keyframe.root_m)


def test_what_is_edited_is_the_first_body_and_the_others_motion_stays(path: Path) -> None:
    assert main(["track", str(path)]) == 0
    before = load_session(path)
    doc = before.changed({"results": None})
    after = doc.with_up((0.0, -1.0, 0.0))
    records = [base_record(Moment(doc)), edit_record(Moment(doc), Moment(after))]
    journal_path(path).write_bytes(lines(records))
    found = open_session(path).session
    assert found.world.up_world == (0.0, -1.0, 0.0)
    assert [body.results for body in found.bodies] == [body.results for body in before.bodies]
    assert mark_of(found) == mark_of(after)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda s: {"bodies": (s.subject, s.subject)}, "bodies: two have the id 'body'"),
        (lambda s: {"views": (s.view, s.view)}, "views: two have the id 'view'"),
        (lambda s: {"bodies": ()}, "bodies"),
        (lambda s: {"views": ()}, "views"),
        (
            lambda s: {
                "views": (
                    s.view,
                    s.view.model_copy(
                        update={
                            "id": "other",
                            "video": s.view.video.model_copy(update={"frame_count": 3}),
                        }
                    ),
                )
            },
            "without a clock views must have the same frames",
        ),
        (
            lambda s: {"views": (s.view.model_copy(update={"p_camera_world": (0.0, 0.0, 1.0)}),)},
            "the first, whose camera is the world's frame",
        ),
    ],
)
def test_views_and_bodies_that_do_not_fit_are_refused(change: Any, words: str) -> None:
    session = cases.session()
    with pytest.raises(ValidationError) as refused:
        Session.model_validate(session.model_copy(update=change(session)).model_dump())
    assert words in one_sentence(refused.value).lower()


def test_a_second_view_is_kept_with_where_its_camera_stands() -> None:
    session = cases.session()
    aside = session.view.model_copy(
        update={
            "id": "aside",
            "R_camera_world_wxyz": (0.6, 0.0, 0.8, 0.0),
            "p_camera_world": (0.5, 0.0, 2.0),
        }
    )
    scene = session.model_copy(update={"views": (session.view, aside)})
    again = Session.model_validate_json(scene.model_dump_json())
    assert again == scene
    assert again.view == session.view
    p_world = np.array([0.3, -0.2, 4.0, 1.0])
    x, z = -0.28 * 0.3 + 0.96 * 4.0, -0.96 * 0.3 - 0.28 * 4.0
    expected = [0.5 + x, -0.2, 2.0 + z]
    np.testing.assert_allclose((again.views[1].T_camera_world @ p_world)[:3], expected)


def keypoint_file(digit: str) -> KeypointFile:
    return KeypointFile(file=f"keypoints-{digit * 12}.npz", source="BlazePose")


def with_keypoints_of(session: Session, *bodies: str) -> Session:
    """Each of these bodies with keypoints of its own."""
    for number, body_id in enumerate(bodies):
        session = session.about(body_id).changed({"keypoints": keypoint_file(f"{number}")})
    return session.about("body")


def test_each_body_has_its_own_keypoints_and_leaves_the_others_theirs(path: Path) -> None:
    session = with_keypoints_of(load_session(path), "body", "second")
    first, second = (session.about(body.id) for body in session.bodies)
    assert first.view.keypoints == keypoint_file("0")
    assert second.view.keypoints == keypoint_file("1")
    assert second.about("body") == session
    save_session(second, path)
    assert load_session(path) == second


def test_keypoints_of_a_view_that_is_not_there_are_refused(path: Path) -> None:
    session = load_session(path)
    of_view = {"nowhere": ViewKeypoints(keypoints=keypoint_file("1"))}
    second = session.bodies[1].model_copy(update={"keypoints_by_view": of_view})
    with pytest.raises(ValidationError, match="no view of the id"):
        Session.model_validate_json(session.with_body(second).model_dump_json())
