"""Word what is known of a film beside the first: when it was taken, and where its camera stands."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from keypose.app.words.bodies import body_names
from keypose.tracker.errors import listed
from keypose.tracker.films.errors import FilmErrors
from keypose.tracker.geometry.rotations import Array, transpose
from keypose.tracker.keypoints.on_body import is_persons
from keypose.tracker.session import Session
from keypose.tracker.session.views import View

if TYPE_CHECKING:
    from keypose.tracker.formats.cameras.calibrated_pair import CalibratedPair
    from keypose.tracker.keypoints.find_people import PeopleInFilm
    from keypose.tracker.operations.mend_keyframes import MendedKeyframes

OPPOSITE_DEG: Final = 150.0
"""Cameras from there on share a blind axis."""
SAME_RATE: Final = 1e-6
"""By which share rates are one, rounded as they are."""


def film_words(view: View) -> str:
    """Such as "side.mp4 begins 3.4 ± 0.2 frames after the first film. Its camera stands 5.1 m from
    the first one's (± 0.4 m), turned by 62° (± 3°)."."""
    name = Path(view.video.path).name
    away, turned = np.linalg.norm(place_of(view)), turned_deg(view)
    it_is = "stands" if view.camera_motion is None else "moves; as the film begins it is"
    where = f"Its camera {it_is} {away:.1f} m from the first one's{_metres(view)}, turned by "
    return f"{name} {clock_words(view)}. {where}{turned:.0f}°{_degrees(view)}."


def chosen_words(view: View, people: int) -> str:
    """Says of how many people in a film one was taken; empty where there is no other."""
    if people < 2:
        return ""
    return (
        f"Of {people} people in {Path(view.video.path).name} the one was taken who moves as in the "
        "first film."
    )


def unfloored_words(before: Session) -> str:
    """Says that feet are to be stood on the floor again; empty where they did not stand there."""
    if before.world.floor_m is None:
        return ""
    return (
        "The floor was that of the first film alone: stand on the floor again once it is tracked."
    )


def left_out_words(before: Session) -> str:
    """Says which people of a session are not looked for in a film that is added; empty where there
    is nobody else."""
    names = body_names(before)
    left_out = [
        names[body.id]
        for body in before.bodies
        if body is not before.subject and is_persons(body.body)
    ]
    if not left_out:
        return ""
    are = "is" if len(left_out) == 1 else "are"
    return f"{listed(left_out)} {are} not looked for in it: there its pictures count alone."


def opposite_words(session: Session, view: View) -> str:
    """Says so where a film sees the person from the other side; empty otherwise."""
    if aside_deg(session, view) < OPPOSITE_DEG:
        return ""
    return (
        "It sees the person from the other side: neither film shows how far away limbs are along "
        "that line. One from the side shows more."
    )


def same_view_words(name: str) -> str:
    """Why a film is not added that shows the person from where the first does."""
    return (
        f"{name} looks at the person as the first film does, so it says nothing of depth: "
        "add one that was taken from the side."
    )


def aside_deg(session: Session, view: View) -> float:
    """Between the directions from which the first film and a view's see the body, as it is posed in
    the median."""
    posed = [*session.subject.keyframes, *session.subject.drafts]
    if not posed:
        return 90.0
    p = np.median([each.root_m for each in posed], axis=0)
    from_view = p - place_of(view)
    cosine = p @ from_view / (np.linalg.norm(p) * np.linalg.norm(from_view))
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def clock_words(view: View) -> str:
    """Such as "begins 3.4 ± 0.2 frames after the first film"."""
    if view.clock is None:
        return "has the frames of the first film"
    begins, sigma = view.clock.begins, view.clock.sigma
    off = "" if sigma is None else f" ± {max(2 * sigma, 0.05):.1f}"
    words = f"begins {abs(begins):.1f}{off} frames {'before' if begins < 0 else 'after'} the first"
    if abs(view.clock.rate - 1) > 1e-4:
        words += f" film, at {view.clock.rate:.5g} of its frame rate"
    else:
        words += " film"
    if not view.clock.also:
        return words
    others = " or ".join(f"{each:.1f}" for each in view.clock.also)
    return f"{words}; the motion repeats itself, so it may as well begin at {others}"


def rate_words(view: View, rate: float) -> str:
    """Such as "side.mp4 is played 1.00 % slower than it was recorded, as the body shows: its clock
    follows that."; empty where it is not.  rate: of `Clock`, as the files say."""
    share = view.film_clock.rate / rate - 1
    if abs(share) < SAME_RATE:
        return ""
    # more frames in the same time are a film that is played too slowly
    how = "slower" if share > 0 else "faster"
    return (
        f"{Path(view.video.path).name} is played {100 * abs(share):.2f} % {how} than it was "
        "recorded, as the body shows: its clock follows that."
    )


def pair_words(pair: CalibratedPair, view: View) -> str:
    """Such as "rig.toml: the films are its cameras cam03 and cam02. The body shows cam02 turned by
    1.6° from where the file has it."."""
    first, second = pair.names
    off = pair.turned_deg(view.T_camera_world)
    return (
        f"{pair.file}: the films are its cameras {first} and {second}. The body shows {second} "
        f"turned by {off:.1f}° from where the file has it."
    )


def lens_words(before: View, after: View, file: str = "") -> str:
    """Such as "Both films show that the first one's lens is 24 mm, not 29 mm."; empty where it
    stays.  file: that says so; empty where the films do."""
    was, is_now = before.camera.focal_mm, after.camera.focal_mm
    if round(was) == round(is_now):
        return ""
    who = f"{file} says" if file else "Both films show"
    return f"{who} that the first one's lens is {is_now:.0f} mm, not {was:.0f} mm."


def mended_words(mended: MendedKeyframes) -> str:
    """Such as "4 keyframes were mended by what all films show, by 6 cm in the median."."""
    count = len(mended.moved_m)
    if not count:
        return ""
    middle = 100 * float(np.median(list(mended.moved_m.values())))
    noun = "1 keyframe was" if count == 1 else f"{count} keyframes were"
    return f"{noun} mended by what all films show, by {middle:.0f} cm in the median."


def by_films_words(count: int, moved_m: float) -> str:
    """Such as "Fitted to what 2 films show: joints moved by 6 cm in the median."."""
    return (
        f"Fitted to what {count} films show: joints moved by {100 * moved_m:.0f} cm in the median."
    )


def film_errors_words(films: Sequence[FilmErrors]) -> str:
    """Such as "Joints lie 4 px from where front.mp4 shows them and 6 px in side.mp4, in the
    median."; empty where no film shows any."""
    errors = [(film.median_px, film.name) for film in films if np.isfinite(film.median_px)]
    if not errors:
        return ""
    (first_px, first), *others = [(f"{px:.1f}" if px < 10 else f"{px:.0f}", n) for px, n in errors]
    rest = [f"{px} px in {name}" for px, name in others]
    start = f"{first_px} px from where {first} shows them"
    return f"Joints lie {listed([start, *rest])}, in the median."


def whom_words(people: PeopleInFilm | None, name: str) -> str:
    """Why a film cannot be added where nobody is found in it, None, or several people are."""
    if people is None:
        return f"No person was found in {name}."
    return (
        f"{len(people.people)} people are to be seen in {name} at frame {people.frame}: add it by "
        "`keypose add-film`, whose --box says who is meant."
    )


def place_of(view: View) -> Array:
    """(3,) where the view's camera is in the first camera's frame, metres."""
    T = view.T_camera_world
    return np.asarray(-transpose(T[:3, :3]) @ T[:3, 3])


def turned_deg(view: View) -> float:
    """By how much the view's camera is turned from the first one's."""
    cosine = (np.trace(view.T_camera_world[:3, :3]) - 1) / 2
    return float(np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0))))


def _metres(view: View) -> str:
    sigma = view.placed and view.placed.place_sigma_m
    return f" (± {sigma:.1f} m)" if sigma else ""


def _degrees(view: View) -> str:
    sigma = view.placed and view.placed.turn_sigma_rad
    return f" (± {np.degrees(sigma):.0f}°)" if sigma else ""
