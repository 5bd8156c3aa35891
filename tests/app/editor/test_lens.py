"""The lens is chosen by what it is called, and what was posed stays where it is seen."""

from __future__ import annotations

import math

import numpy as np
import pytest

from keypose.app.editor.documents import ActionRefused
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.state import EditorState
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.session.schema import Session
from tests.app.editor.desk import after, desk


def seen(state: EditorState) -> Array:
    """(P, 2) where the joints are seen at the present frame."""
    Ts = pose_transforms(state.skeleton, shown_pose(state).pose)
    return state.doc.view.camera.without_distortion().project(Ts[:, :3, 3])


def across_deg(camera: Camera) -> float:
    return math.degrees(2 * math.atan(max(camera.width, camera.height) / 2 / camera.fx))


@pytest.mark.parametrize(("mm", "deg"), [(26, 69.4), (13, 108.3), (77, 26.3), (36, 53.1)])
def test_a_lens_shows_as_much_across_as_on_film(mm: float, deg: float) -> None:
    camera = after(desk(), {"do": "lens", "mm": mm}).doc.view.camera
    assert across_deg(camera) == pytest.approx(deg, abs=0.1)
    assert camera.focal_mm == pytest.approx(mm)


@pytest.mark.parametrize(
    ("message", "source", "is_guess"),
    [
        ({"do": "lens", "mm": 26, "known": "file"}, "file", False),
        ({"do": "lens", "mm": 26}, "person", False),
        ({"do": "lens"}, "guess", True),
        ({"do": "lens", "mm": 26, "known": "guess"}, "guess", True),
        ({"do": "field_of_view", "deg": 60}, "person", False),
        ({"do": "camera", "fx": 900}, "calibration", False),
    ],
    ids=str,
)
def test_the_session_keeps_what_the_lens_rests_on(
    message: dict[str, object], source: str, is_guess: bool
) -> None:
    doc = after(desk(), message).doc
    assert (doc.view.lens_source, doc.view.lens_is_guess) == (source, is_guess)
    assert Session.model_validate_json(doc.model_dump_json()).view.lens_source == source


def test_a_session_that_was_never_asked_says_nothing_of_it() -> None:
    doc = desk().doc
    assert "lens_source" not in doc.model_dump_json()
    guessed = doc.changed({"camera": Camera.guess(640, 360)})
    assert guessed.view.lens_is_guess
    assert not doc.view.lens_is_guess


def test_depth_on_a_guessed_lens_is_as_doubtful_as_usual_lenses_differ_from_it() -> None:
    guessed = after(desk(), {"do": "lens"})
    assert guessed.doc.view.depth_share is not None
    farthest = max(
        abs(
            Camera.from_field_of_view(640, 360, np.radians(deg)).fx / guessed.doc.view.camera.fx - 1
        )
        for deg in (40, 65)
    )
    assert guessed.doc.view.depth_share == pytest.approx(farthest)
    assert after(guessed, {"do": "lens", "mm": 26}).doc.view.depth_share is None


@pytest.mark.parametrize("message", [{"do": "lens", "mm": 77}, {"do": "field_of_view", "deg": 30}])
def test_what_was_posed_stays_where_it_is_seen_and_stands_farther_away(
    message: dict[str, object],
) -> None:
    before, longer = desk(), after(desk(), message)
    ratio = longer.doc.view.camera.fx / before.doc.view.camera.fx
    assert ratio > 1.3
    for one, other in zip(before.doc.subject.keyframes, longer.doc.subject.keyframes, strict=True):
        np.testing.assert_allclose(other.root_m, np.array(one.root_m) * (1, 1, ratio))
    root = seen(before)[0], seen(longer)[0]
    np.testing.assert_allclose(*root, atol=1e-6)
    assert np.abs(seen(before) - seen(longer)).max() < 12  # the rest by its smaller perspective


def test_before_anything_is_posed_the_body_fills_the_picture_with_any_lens() -> None:
    state = desk(keyframes=False)
    height = np.ptp(seen(state)[:, 1])
    for mm in (13, 26, 77, 200):
        changed = after(state, {"do": "lens", "mm": mm})
        assert np.ptp(seen(changed)[:, 1]) == pytest.approx(height, rel=0.1)


def test_an_action_camera_bends_straight_edges_and_another_lens_does_not() -> None:
    bent = after(desk(), {"do": "lens", "mm": 16, "bent": True})
    camera = bent.doc.view.camera
    x = np.linspace(0.1, 1.2, 12)
    p = np.stack([x, 0 * x, np.ones_like(x)], axis=1)
    seen_at = (camera.project(p)[:, 0] - camera.cx) / camera.fx
    np.testing.assert_allclose(seen_at, np.arctan(x), atol=2e-3)
    still = after(bent, {"do": "lens", "mm": 20})
    assert still.doc.view.camera.distortion == camera.distortion
    straight = after(bent, {"do": "lens", "mm": 26, "bent": False})
    assert not straight.doc.view.camera.is_distorted


def test_a_lens_so_wide_that_the_body_comes_behind_the_camera_is_refused() -> None:
    with pytest.raises(ActionRefused, match=r"^.*camera.*\.$"):
        after(desk(), {"do": "root", "z": 1.5}, {"do": "lens", "mm": 4})


# --- what is up


def test_a_level_camera_is_one_press_and_one_step() -> None:
    level = after(desk(), {"do": "level_camera"})
    assert level.doc.world.up_world == (0.0, -1.0, 0.0)
    assert level.history.total == 1
    assert after(level, {"do": "undo"}).doc.world.up_world is None


def upright(camera: Camera, x_m: float, tilt_deg: float) -> list[tuple[float, float]]:
    """Both ends of a pole, as a camera sees it that looks down by so much."""
    c, s = math.cos(math.radians(tilt_deg)), math.sin(math.radians(tilt_deg))
    poles = np.array([(x_m, -0.8 * c * k, 6.0 - 0.8 * s * k) for k in (-1, 1)])
    return [(float(u), float(v)) for u, v in camera.project(poles)]


def test_two_verticals_show_how_far_the_camera_looks_down() -> None:
    camera = desk().doc.view.camera
    (a, b), other = upright(camera, -1.5, 14.0), upright(camera, 1.5, 14.0)
    one = after(desk(), {"do": "vertical", "a": a, "b": b})
    assert one.doc.world.up_world is not None
    assert abs(one.doc.world.up_world[2]) < 0.05
    both = after(one, {"do": "vertical", "a": a, "b": b, "other": other})
    assert both.doc.world.up_world is not None
    assert math.degrees(math.asin(-both.doc.world.up_world[2])) == pytest.approx(14.0, abs=0.2)


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ([(210.0, 100.0), (190.0, 300.0)], "cross in the picture"),
        ([(200.3, 101.0), (200.8, 299.0)], "farther apart"),
    ],
)
def test_verticals_that_cross_or_are_one_line_are_refused(
    other: list[tuple[float, float]], words: str
) -> None:
    line = {"do": "vertical", "a": (190.0, 100.0), "b": (210.0, 300.0)}
    if words == "farther apart":
        line = {"do": "vertical", "a": (200.0, 100.0), "b": (200.5, 300.0)}
    with pytest.raises(ActionRefused, match=words):
        after(desk(), {**line, "other": other})
