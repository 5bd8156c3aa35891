"""Posing and picking in the picture of another film, whose camera stands elsewhere."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.frames import pointer_views
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.posing import Gesture, parts_at
from keypose.tracker.session.between_views import T_film_first, lens_in
from tests.app.editor.desk import after, desk
from tests.app.film_beside_cases import ID, with_film
from tests.app.posing.posing_cases import Floats, points

FRAME = 24


def two_films() -> EditorState:
    return after(replace(desk(), doc=with_film(desk().doc)), {"do": "go", "frame": FRAME})


def seen(state: EditorState, name: str) -> tuple[Floats, Floats]:
    """Where a joint or landmark is seen in the first film and in the other."""
    views = pointer_views(state.doc, FRAME, film=ID)
    p = points(state.doc.subject.body, shown_pose(state).pose)[name]
    return views["main"].project(p), views["film"].project(p)


def pulled(state: EditorState, name: str, way: Any, **more: Any) -> EditorState:
    start = seen(state, name)[1]
    handle = {"kind": "root"} if name == "waist" else {"kind": "end", "name": name}
    spots = {"from": start.tolist(), "at": (start + way).tolist()}
    return after(
        state, {"do": "drag", "view": "film", "film": ID, "handle": handle, **spots, **more}
    )


def test_its_view_is_what_its_camera_sees_of_the_moment() -> None:
    doc = two_films().doc
    T, lens = T_film_first(doc, doc.views[1], FRAME), lens_in(doc, doc.views[1], FRAME)
    p = np.array([[0.2, -0.3, 5.0], [-0.4, 0.5, 6.0]])
    view = pointer_views(doc, FRAME, film=ID)["film"]
    np.testing.assert_allclose(view.project(p), lens.project(p @ T[:3, :3].T + T[:3, 3]))
    origin, direction = view.ray(view.project(p[0]))
    np.testing.assert_allclose(np.cross(p[0] - origin, direction), 0, atol=1e-9)


def test_a_hand_comes_under_the_pointer_there_and_the_other_ends_stay_in_space() -> None:
    before = two_films()
    state = pulled(before, "left_hand", (14.0, -11.0))
    want = seen(before, "left_hand")[1] + (14.0, -11.0)
    np.testing.assert_allclose(seen(state, "left_hand")[1], want, atol=0.5)
    for name in ("right_hand", "left_foot"):
        np.testing.assert_allclose(seen(state, name), seen(before, name), atol=1e-6)


@pytest.mark.parametrize("name", ["left_hand", "waist"])
def test_with_depth_it_keeps_its_place_in_the_first_film(name: str) -> None:
    before = two_films()
    sight = seen(before, name)
    p = points(before.doc.subject.body, shown_pose(before).pose)[name]
    film = pointer_views(before.doc, FRAME, film=ID)["film"]
    way = film.project(0.995 * p) - sight[1]
    state = pulled(before, name, way, depth=True)
    np.testing.assert_allclose(seen(state, name)[0], sight[0], atol=1.0)
    np.testing.assert_allclose(seen(state, name)[1], sight[1] + way, atol=2.0)


def test_a_part_is_picked_where_the_other_film_shows_it() -> None:
    state = two_films()
    view = pointer_views(state.doc, FRAME, film=ID)["film"]
    found = parts_at(state.skeleton, shown_pose(state).pose, view, seen(state, "chest")[1])
    assert {"chest", "waist"} & set(found)


@pytest.mark.parametrize(
    "place", [{"view": "film"}, {"view": "main", "film": ID}, {"view": "film", "film": "No Such"}]
)
def test_a_drag_says_in_which_film_it_is(place: dict[str, str]) -> None:
    sent = {"handle": {"kind": "root"}, "from": (0, 0), "at": (1, 1), **place}
    with pytest.raises(ValidationError):
        Gesture.model_validate(sent)


def test_a_drag_in_a_film_that_is_gone_is_refused() -> None:
    gone = after(two_films(), {"do": "remove_film", "view": ID})
    place = {"view": "film", "film": ID, "handle": {"kind": "root"}, "from": [0, 0], "at": [4, 4]}
    with pytest.raises(ActionRefused, match="not in the session any more"):
        after(gone, {"do": "drag", **place})
