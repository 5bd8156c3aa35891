"""A tracked motion stands on its floor: by one call, undone by none, and refused in a sentence."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import joint_names
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import Trajectory
from keypose.tracker.errors import SessionError
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.geometry.up import UpEvidence, UpSource
from keypose.tracker.operations.find_up import estimated_up
from keypose.tracker.operations.kept_pins import without_harm
from keypose.tracker.operations.solve_space import films_in_space, solved
from keypose.tracker.operations.stand import Standing, stand, with_things_along
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.session.annotations import Drafted
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.session.bonds import Bond, BondEnd
from keypose.tracker.session.camera_motion import CameraMotion, CameraPiece
from keypose.tracker.session.pins import Pin
from keypose.tracker.session.results import Results as SavedResults
from keypose.tracker.session.settings import TrackSettings
from keypose.tracker.session.views import Clock
from keypose.tracker.solver.projection import image_points
from keypose.tracker.space.soles import Soles, measured_soles, soles_of
from keypose.tracker.storage import stretches as solves
from keypose.tracker.storage.fingerprints import Span
from keypose.tracker.storage.results import Results
from keypose.tracker.storage.stretches import stretches
from keypose.tracker.tracking.result import SegmentResult
from tests.app.film_beside_cases import with_film
from tests.tracker.operations.standing_cases import (
    KEYS,
    session_of,
    tracked,
    walk,
    wandering,
)
from tests.tracker.operations.standing_cases import lines as upright

SHOWN, UP = walk()
JOINTS = [
    i for i, name in enumerate(joint_names(SHOWN.skeleton)) if not name.endswith(("heel", "toe"))
]
"""All but what says how a foot stands."""
MOTION = wandering(SHOWN.truth)


def session(**changes: Any) -> Session:
    return session_of(SHOWN, MOTION, **changes)


def stood(given: Session, seen: UpEvidence | None = None) -> Standing:
    return stand(given, tracked(given, MOTION), seen)


def soles(done: Standing) -> Soles:
    """As they lie once the motion is solved for again."""
    fitting = tracked(done.session, MOTION)
    found = [solved(done.session, run) for run in stretches(done.session, fitting)]
    measured = soles_of(done.session, found)
    assert measured is not None
    return measured


def known(**changes: Any) -> Session:
    x, y, z = UP.tolist()
    return session(up_world=(x, y, z), **changes)


def test_feet_are_pinned_on_one_floor_and_soles_lie_within_a_centimetre() -> None:
    done = stood(known())
    assert done.taken >= 4
    assert all(pin.floor for pin in done.session.subject.pins)
    assert abs(soles(done).off_m) < 0.01
    lowest = float((SHOWN.truth.joints(SHOWN.skeleton)[0] @ UP).min())
    assert done.session.world.floor_m == pytest.approx(lowest, abs=0.12)


def test_keyframes_stay_in_the_picture_and_give_way_in_depth() -> None:
    done = stood(known())
    assert done.softened == KEYS
    assert {keyframe.soft for keyframe in done.session.subject.keyframes} == {"depth"}
    run = stretches(done.session, tracked(done.session, MOTION))[0]
    motion = solved(done.session, run).motion
    for frame in KEYS:
        uv = [SHOWN.camera.project(one.joints(SHOWN.skeleton)[frame]) for one in (motion, MOTION)]
        assert np.linalg.norm(uv[0] - uv[1], axis=-1)[JOINTS].max() < 1.5, frame


def test_soft_keyframes_stay_as_soft_as_they_were() -> None:
    given = known()
    soft = tuple(k.model_copy(update={"soft": True}) for k in given.subject.keyframes)
    done = stood(given.changed({"keyframes": soft}))
    assert done.softened == ()
    assert {keyframe.soft for keyframe in done.session.subject.keyframes} == {True}


def test_pins_that_are_there_stay_and_come_onto_the_floor() -> None:
    pin = Pin(part="left_foot", landmarks=("left_heel", "left_toe"), first_frame=48, last_frame=54)
    hand = Pin(part="left_hand", first_frame=3, last_frame=9)
    done = stood(known(pins=(pin, hand)))
    assert done.session.subject.pins[0] == pin.model_copy(update={"floor": True})
    assert done.session.subject.pins[1] == hand
    assert not any(other.overlaps(pin) for other in done.session.subject.pins[1:])


def test_up_is_what_was_set_or_else_what_all_that_shows_it_agrees_on() -> None:
    assert stood(known()).up.sources == ("set",)
    both = stood(session(), upright(UP).evidence)
    assert both.up.sources[0] == "lines"
    assert both.session.world.up_from == both.up.sources
    np.testing.assert_allclose(both.session.world.up_world, UP, atol=1.5e-2)
    alone = stood(session())
    assert set(alone.up.sources) <= {"person", "feet"}
    assert not alone.up.apart
    off = np.arccos(np.array(alone.session.world.up_world) @ UP)
    assert off < 2 * alone.up.sigma_rad
    assert both.up.sigma_rad < alone.up.sigma_rad


def test_up_that_was_found_is_found_anew_and_what_was_set_stays() -> None:
    once = stood(session(), upright(UP).evidence)
    again = stood(once.session, upright(UP).evidence)
    np.testing.assert_allclose(again.up.up, once.up.up, atol=2e-3)
    assert stood(known(), upright(-UP @ np.diag([1, 1, -1])).evidence).up.up == pytest.approx(
        UP, abs=1e-6
    )


@pytest.mark.parametrize("up_from", [("person", "set"), ("feet", "set"), ("set",)])
@pytest.mark.parametrize("sigma_deg", [None, 2.0])
def test_up_that_somebody_chose_of_what_was_found_stays_and_what_disagrees_is_named(
    up_from: tuple[UpSource, ...], sigma_deg: float | None
) -> None:
    sigma_rad = None if sigma_deg is None else np.radians(sigma_deg)
    chosen = known(up_from=up_from, up_sigma_rad=sigma_rad)
    other = exp_rotation(np.array([np.radians(25.0), 0.0, 0.0])) @ UP
    done = stood(chosen, upright(other).evidence)
    np.testing.assert_allclose(done.up.up, UP, atol=1e-6)
    assert done.session.has_up_of_hand
    assert done.session.world.up_from == up_from
    assert [one.evidence.source for one in done.up.apart] == ["lines"]


@pytest.mark.parametrize("turned_deg", [0.0, 15.0])
def test_lines_that_are_far_from_what_was_set_are_named_and_change_nothing(
    turned_deg: float,
) -> None:
    other = exp_rotation(np.array([np.radians(turned_deg), 0.0, 0.0])) @ UP
    done = stood(known(), upright(other).evidence)
    assert done.session.has_up_of_hand
    named = [one.evidence.source for one in done.up.apart]
    assert named == (["lines"] if turned_deg else [])


def test_what_shows_no_more_than_how_cameras_are_held_is_no_up() -> None:
    still = Trajectory(0, MOTION.Rs_parent_part[[50] * 91], MOTION.ps_camera_root[[50] * 91])
    drafted = Drafted(first_frame=0, last_frame=90, up_camera=tuple(UP.tolist()))
    pin = Pin(part="left_foot", landmarks=("left_heel", "left_toe"), first_frame=3, last_frame=60)
    assert estimated_up(session(drafted=drafted, pins=(pin,)), {(0, 90): still}) is None
    found = estimated_up(session(pins=(pin,)), {(0, 90): still})
    assert found is not None
    assert found.sources[0] == "person"


@pytest.mark.parametrize("roll_deg", [0.0, 8.0])
def test_twenty_pinned_stances_all_over_a_floor_show_up_without_anybody_upright(
    roll_deg: float,
) -> None:
    turn = exp_rotation(np.radians([0.0, 0.0, roll_deg]))
    up, rng = turn @ UP, np.random.default_rng(4)
    foot = SHOWN.skeleton.body.index("left_foot")
    R, t = MOTION.writable()
    R[50, 0] = turn @ R[50, 0]
    one = Trajectory(0, R[[50]], t[[50]])
    start = one.transforms(SHOWN.skeleton)[0, foot, :3, 3]
    across = np.linalg.svd(up[None])[2][1:]
    floor = -1.6 * up + 6.0 * np.array([0.0, 0.0, 1.0])
    spots = floor + rng.uniform(-1.5, 1.5, (20, 2)) @ across + rng.normal(0, 0.02, (20, 3))
    R, t = np.repeat(one.Rs_parent_part, 60, 0), np.repeat(one.ps_camera_root, 60, 0)
    t = t + np.repeat(spots - start, 3, 0)
    pins = tuple(
        Pin(part="left_foot", landmarks=("left_heel", "left_toe"), first_frame=3 * n,
            last_frame=3 * n + 2)
        for n in range(20)
    )  # fmt: skip
    drafted = Drafted(first_frame=0, last_frame=59, up_camera=tuple(UP.tolist()))
    found = estimated_up(session(drafted=drafted, pins=pins), {(0, 59): Trajectory(0, R, t)})
    assert found is not None
    assert found.sources == ("feet",)
    off_deg = np.degrees(np.arccos(found.up @ up))
    assert off_deg < 2 * np.degrees(found.sigma_rad) < 6


@pytest.mark.parametrize(("is_static", "shows"), [(None, True), (True, True), (False, False)])
def test_a_camera_that_moves_nobody_knows_how_shows_no_up_by_what_is_seen_in_it(
    is_static: bool | None, shows: bool
) -> None:
    settings = TrackSettings(smooth=True, static_camera=is_static)
    given = session(settings=settings)
    assert (estimated_up(given, {(0, 90): MOTION}) is not None) == shows
    found = estimated_up(given, {(0, 90): MOTION}, upright(UP).evidence)
    assert found is not None
    assert found.sources[0] == "lines"
    if not shows:
        with pytest.raises(SessionError, match="camera moves, and how is not known") as refused:
            stood(given)
        assert str(refused.value).count(".") == 1


def test_drafts_that_were_balanced_for_an_up_do_not_bear_it_out() -> None:
    drafted = Drafted(first_frame=0, last_frame=90, up_camera=tuple(UP.tolist()))
    found = estimated_up(session(drafted=drafted), {(0, 90): MOTION}, upright(UP).evidence)
    assert found is not None
    assert "person" not in [one.source for one in found.used]


def test_a_hand_on_the_floor_stays_there_and_is_no_sole() -> None:
    hand = Pin(part="left_hand", first_frame=3, last_frame=9, floor=True)
    done = stood(known(pins=(hand,)))
    assert done.session.subject.pins[0] == hand
    assert soles(done).part.endswith("foot")
    alone = measured_soles(SHOWN.skeleton, [MOTION], [hand], UP, -1.7)
    assert alone is None


def test_a_foot_pinned_beyond_what_is_tracked_stands_on_the_floor_as_far_as_it_is() -> None:
    pin = Pin(part="left_foot", landmarks=("left_heel", "left_toe"), first_frame=48, last_frame=80)
    given = known(pins=(pin,))
    whole = tracked(given, MOTION)
    done = stand(given, {span: found for span, found in whole.items() if span[1] <= 60})
    assert done.session.subject.pins[0] == pin.model_copy(update={"floor": True})
    assert done.softened == KEYS[:3]
    untracked = pin.model_copy(update={"first_frame": 62})
    other = pin.model_copy(
        update={"part": "right_foot", "landmarks": ("right_heel", "right_toe"), "first_frame": 0}
    )
    given = known(pins=(untracked, other.model_copy(update={"last_frame": 90})))
    only = {span: found for span, found in whole.items() if span[1] <= 30}
    assert np.isfinite(stand(given, only).session.world.floor_m or np.nan)


def test_without_a_foot_pinned_where_the_motion_is_tracked_there_is_no_floor() -> None:
    hops = Pin(part="left_foot", landmarks=("left_heel", "left_toe"), first_frame=70, last_frame=80)
    given, (R, t) = known(pins=(hops,)), MOTION.writable()
    t[:, 0] += 0.1 * np.arange(len(t))
    whole = tracked(given, type(MOTION)(0, R, t))
    with pytest.raises(SessionError, match="No foot stands still"):
        stand(given, {span: found for span, found in whole.items() if span[1] <= 60})


def test_a_foot_that_stands_across_two_solves_is_pinned_once_at_the_frame_between(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(solves, "LONGEST", 40)
    done = stood(known())
    feet = [pin for pin in done.session.subject.pins if pin.part == "right_foot"]
    assert any(pin.last_frame == KEYS[1] for pin in feet)
    assert any(pin.first_frame == KEYS[1] + 1 for pin in feet)
    assert Session.model_validate_json(done.session.model_dump_json()) == done.session


def test_a_foot_on_something_higher_is_left_there_and_named() -> None:
    pin = Pin(part="left_foot", landmarks=("left_heel", "left_toe"), first_frame=46, last_frame=56)
    R, t = MOTION.writable()
    t[44:60] += 0.5 * UP
    given = known(pins=(pin,))
    done = stand(given, tracked(given, type(MOTION)(0, R, t)))
    assert pin in done.raised
    assert not done.session.subject.pins[0].floor


# --- what a pin does to the motion


def slid(metres: float) -> Trajectory:
    """The tracked walk whose left foot was seen to slide in its stance about frame 50, as much as
    the whole body."""
    R, t = MOTION.writable()
    share = np.clip((np.arange(len(t)) - 44) / 14, 0, 1)
    t[:, 0] += metres * (share**2 * (3 - 2 * share))
    return type(MOTION)(0, R, t)


STANCE = Pin(part="left_foot", landmarks=("left_heel", "left_toe"), first_frame=46, last_frame=56)


def test_a_pin_that_moves_a_leg_in_the_picture_is_released_if_it_was_proposed_and_told_if_set() -> (
    None
):
    motion = slid(0.3)
    given = known(pins=(STANCE,))
    told = stand(given, tracked(given, motion))
    held = [harm for harm in told.harms if harm.pin.span == STANCE.span]
    assert max(harm.share for harm in held) > 1
    assert told.session.subject.pins[0] == STANCE.model_copy(update={"floor": True})
    fitting = tracked(given, motion)
    floor = session_of(SHOWN, motion, up_world=tuple(UP), pins=told.session.subject.pins)
    kept = without_harm(floor, floor.subject.pins[:1], fitting)
    assert [harm.pin for harm in kept.released] == [floor.subject.pins[0]]
    assert floor.subject.pins[0] not in kept.session.subject.pins
    assert len(kept.session.subject.pins) == len(floor.subject.pins) - 1


@pytest.mark.parametrize("others", [(), ((70, 80),)], ids=["none", "where nothing is tracked"])
def test_where_no_pin_could_stay_that_is_said_and_why(others: tuple[Span, ...]) -> None:
    motion = slid(0.5)
    pins = [STANCE.model_copy(update={"floor": True, "first_frame": a, "last_frame": b})
            for a, b in (STANCE.span, *others)]  # fmt: skip
    floor = session_of(SHOWN, motion, up_world=tuple(UP), pins=tuple(pins))
    fitting = {s: found for s, found in tracked(floor, motion).items() if s[1] <= 60}
    with pytest.raises(SessionError, match=r"No foot can be held .* would move .* px"):
        without_harm(floor, floor.subject.pins[:1], fitting)


def test_what_was_done_to_a_motion_that_stands_well_is_little() -> None:
    done = stood(known())
    assert not any(harm.is_much for harm in done.harms)
    assert len(done.released) < done.taken / 2
    assert all(harm.is_too_much for harm in done.released)
    assert not {harm.pin for harm in done.released} & set(done.session.subject.pins)
    assert done.tilted_rad < np.radians(1.0)
    assert done.hanging == ()
    assert done.unscaled == ()


# --- a camera whose way has no scale


def carried(frames: Span) -> Session:
    """The walk as a camera sees it that moves, its way of no known length over these frames."""
    count = len(MOTION)
    path = CameraPath(np.tile(np.eye(4), (count, 1, 1)), np.ones(count))
    starts = sorted({0, frames[0], *([frames[1] + 1] if frames[1] + 1 < count else [])})
    pieces = tuple(
        CameraPiece(first_frame=first, metres=None if first == frames[0] else 1.0)
        for first in starts
    )
    return known(camera_motion=CameraMotion.of("moves", path, pieces=pieces))


def test_nothing_is_pinned_where_the_way_of_the_camera_has_no_scale() -> None:
    with pytest.raises(SessionError, match="How far the camera went is not known"):
        stood(carried((0, len(MOTION) - 1)))
    done = stood(carried((45, len(MOTION) - 1)))
    assert done.unscaled == ((45, len(MOTION) - 1),)
    assert done.session.subject.pins
    assert all(pin.last_frame < 45 for pin in done.session.subject.pins)


TRACKED = SavedResults(
    tracks="tracks-0123456789ab.npz", method="keypose", quality="full", segments=()
)


def but(**changes: Any) -> dict[Span, SegmentResult]:
    """What was tracked, but for something of each segment."""
    fitting = tracked(known(), MOTION)
    return {span: replace(found, **changes) for span, found in fitting.items()}


REFUSED = {
    "nothing tracked": (lambda: (known(), {}), "Nothing is tracked yet"),
    "tracked for other settings": (
        lambda: (known(results=TRACKED), {}), "The tracked motion is out of date: track"
    ),
    "a preview": (lambda: (known(), but(quality="preview")), "tracked as a preview: track it in"),
    "frames are missing": (lambda: (known(), but(missing=(3,))), "Frames are missing in every"),
    "a box": (
        lambda: (known(body=preset("box"), keyframes=()), {}), "no feet with heel and toe"
    ),
    "published method": (
        lambda: (known(settings=TrackSettings(method="paper")), {}), "published method"
    ),
    "upside down": (
        lambda: (known_with_up(-UP), None), "By what is set as up the body lies"
    ),
    "never stands": (lambda: (known(), "swims"), "No foot stands still anywhere"),
}  # fmt: skip


def known_with_up(up: Any) -> Session:
    x, y, z = up.tolist()
    return session(up_world=(x, y, z))


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_stand_is_said_in_one_sentence(case: str) -> None:
    make, words = REFUSED[case]
    given, fitting = make()
    if fitting is None:
        fitting = tracked(given, MOTION)
    if fitting == "swims":
        R, t = MOTION.writable()
        t[:, 0] += 0.1 * np.arange(len(t))
        fitting = tracked(given, type(MOTION)(0, R, t))
    with pytest.raises(SessionError, match=words) as refused:
        stand(given, fitting)
    assert str(refused.value).count(".") == 1


def climbing(steepness: float, spread_rad: float) -> Trajectory:
    """The walk, higher by so many times 2 cm in every frame, legs spread at the hips."""
    R, t = MOTION.writable()
    for side, sign in (("left", 1), ("right", -1)):
        thigh = SHOWN.skeleton.body.index(f"{side}_thigh")
        R[:, thigh] = exp_rotation(np.array([0.0, 0.0, sign * spread_rad])) @ R[:, thigh]
    return Trajectory(0, R, t + 0.02 * steepness * np.arange(len(t))[:, None] * UP)


@pytest.mark.parametrize("steepness", [-0.7, -0.5, 0.5, 0.7])
@pytest.mark.parametrize("spread_rad", [-0.25, -0.12, 0.0, 0.25])
def test_stairs_are_no_floor_however_wide_the_gait_and_change_nothing_of_up(
    steepness: float, spread_rad: float
) -> None:
    motion = climbing(steepness, spread_rad)
    with pytest.raises(SessionError, match=r"slope of \d\d° .* as on stairs") as refused:
        stand(session(), tracked(session(), motion))
    assert str(refused.value).count(".") == 1
    found = estimated_up(session(), {(0, 90): motion})
    assert found is not None
    assert [one.evidence.source for one in found.apart] == ["feet"]
    assert np.arccos(found.up @ UP) < 2 * found.sigma_rad


@pytest.mark.parametrize("spread_rad", [-0.25, 0.25])
def test_a_level_floor_is_one_however_wide_the_gait(spread_rad: float) -> None:
    found = estimated_up(session(), {(0, 90): climbing(0.0, spread_rad)})
    assert found is not None
    assert set(found.sources) == {"person", "feet"}
    assert np.arccos(found.up @ UP) < 2 * found.sigma_rad


def test_upright_lines_that_agree_with_feet_outvote_how_the_body_leans() -> None:
    leans = climbing(0.7, 0.0)
    alone = estimated_up(session(), {(0, 90): leans})
    assert alone is not None
    feet = alone.apart[0].evidence
    found = estimated_up(session(), {(0, 90): leans}, upright(feet.up).evidence)
    assert found is not None
    assert "lines" in found.sources
    assert [one.evidence.source for one in found.apart] == ["person"]


def test_frames_in_which_nothing_touches_the_floor_are_told() -> None:
    done = stood(known())
    run = stretches(done.session, tracked(done.session, MOTION))[0]
    R, t = solved(done.session, run).motion.writable()
    t[75:79] += 0.4 * UP
    pins = [pin for pin in done.session.subject.pins if pin.last_frame < 75]
    raised = type(MOTION)(0, R, t)
    measured = measured_soles(SHOWN.skeleton, [raised], pins, UP, done.session.world.floor_m or 0.0)
    assert measured is not None
    assert (75, 78) in measured.in_air


def test_feet_on_the_floor_move_the_body_less_in_the_film_of_the_side_if_the_session_has_it() -> (
    None
):
    x, y, z = UP.tolist()
    one = known()
    two = with_film(one, Clock(begins=0.0)).changed({"up_world": (x, y, z)})
    moved = []
    for given in (one, two):
        done = stood(given)
        (run,) = stretches(done.session, tracked(done.session, MOTION))
        (film,) = films_in_space(two, *run.span)
        uv = [
            image_points(film.camera, each.carried(film.Ts_film_first).joints(SHOWN.skeleton))
            for each in (solved(done.session, run).motion, MOTION)
        ]
        moved.append(np.linalg.norm(uv[0] - uv[1], axis=-1)[:, JOINTS].mean())
    assert moved[1] < 0.5 * moved[0]


def test_a_ball_in_a_hand_goes_along_and_stays_there() -> None:
    doc, ball = session(), preset("ball")
    hand = doc.subject.body.index("left_hand")
    Ts = MOTION.transforms(SHOWN.skeleton)[:, hand]
    where = Trajectory(MOTION.first_frame, Ts[:, None, :3, :3], Ts[:, :3, 3])
    thrown = tuple(
        Keyframe.of(Skeleton.of(ball), where.pose(frame), frame, frame / 30) for frame in KEYS
    )
    ends = [
        BondEnd(body=body_id, part=part, point_m=(0.0, 0.0, 0.0))
        for body_id, part in ((doc.subject.id, "left_hand"), ("ball", ball.names[0]))
    ]
    bond = Bond(
        holder=ends[0], held=ends[1], first_frame=KEYS[0], last_frame=KEYS[-1], moves="held"
    )
    body = TrackedBody(id="ball", body=ball, keyframes=thrown)
    doc = doc.model_copy(update={"bodies": (doc.subject, body), "bonds": (bond,)})
    done = stand(doc, tracked(doc, MOTION))
    whole, along = with_things_along(done.session, {doc.subject.id})
    assert along == ("ball",)
    results = Results()
    for body_id, motion in ((doc.subject.id, MOTION), ("ball", where)):
        for segment in tracked(whole.about(body_id), motion).values():
            results = results.with_result(segment)
    paths = {}
    for body_id in (doc.subject.id, "ball"):
        about = whole.about(body_id)
        for stretch in results.unsolved(about):
            results = results.with_space(solved(about, stretch))
        (stretch,) = results.space(about)
        Ts_body = stretch.motion.transforms(Skeleton.of(about.subject.body))
        paths[body_id] = Ts_body[:, hand if body_id != "ball" else 0, :3, 3]
    moved_m = np.linalg.norm(paths[doc.subject.id] - where.ps_camera_root, axis=1)
    assert moved_m.max() > 0.03
    assert np.linalg.norm(paths[doc.subject.id] - paths["ball"], axis=1).max() < 0.01
