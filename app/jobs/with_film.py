"""The session with a second film: its clock and camera as found, and keyframes mended by it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np

from keypose.app.editor.documents import seen_as_before
from keypose.app.jobs.found_film import FoundFilm
from keypose.app.jobs.synchronised import Synchronised, joints_at, sightings_of
from keypose.app.words.films import (
    chosen_words,
    film_words,
    left_out_words,
    lens_words,
    mended_words,
    opposite_words,
    pair_words,
    rate_words,
    unfloored_words,
)
from keypose.tracker.films.cameras import at_scale_of
from keypose.tracker.films.offset import FoundOffset
from keypose.tracker.formats.cameras.calibrated_pair import CalibratedPair
from keypose.tracker.geometry.rotations import quaternion_wxyz
from keypose.tracker.keypoints.keypoints import Keypoints
from keypose.tracker.operations.mend_keyframes import MendedKeyframes, mend_keyframes
from keypose.tracker.session import Session
from keypose.tracker.session.views import Clock, Placed, View

MOST_DRAFTS = 30
"""That are asked how far away a camera is; neighbouring ones know the same."""


@dataclass(frozen=True, eq=False)
class AddedFilm:
    """A film that was found to show the motion of a session.

    film: the session with the film, and with mended keyframes, and what was seen in the film.
    offset: when it was taken, and where its camera stands.  others: the other offsets that may be
        true.  mended: what became of the keyframes.  rate: frames of it per frame of the first, as
        the files say.  pair: of a calibration, where one was given.  people: of whom the one was
        taken who moves as in the first film.
    """

    film: FoundFilm
    offset: FoundOffset
    others: tuple[FoundOffset, ...]
    mended: MendedKeyframes
    rate: float
    pair: CalibratedPair | None = None
    people: int = 1

    @property
    def session(self) -> Session:
        """With the film as its last view, which has no keypoints yet."""
        return self.film.session

    @property
    def view(self) -> View:
        """Of the film."""
        return self.session.views[-1]

    def saved(self, session_path: Path) -> Session:
        """As of `FoundFilm`."""
        return self.film.saved(session_path)


def added_words(before: Session, added: AddedFilm) -> tuple[str, ...]:
    """What is said of a film that was added to a session, a few sentences."""
    view, pair = added.view, added.pair
    file = "" if pair is None else pair.file
    words = (
        "" if pair is None else pair_words(pair, view),
        film_words(view),
        chosen_words(view, added.people),
        rate_words(view, added.rate),
        opposite_words(added.session, view),
        lens_words(before.view, added.session.view, file),
        mended_words(added.mended),
        unfloored_words(before),
        left_out_words(before),
    )
    return tuple(filter(None, words))


def with_film(
    session: Session,
    view: View,
    keypoints: tuple[Keypoints, Keypoints],
    synchronised: Synchronised,
    network: str,
    at: int,
    also: tuple[float, ...] | None = None,
    *,
    others: Mapping[str, Keypoints],
) -> AddedFilm:
    """The session with a view, its clock and camera as found, and with mended keyframes.

    also: where it may begin besides; None: where the other offsets say.  others: keypoints of films
    that are there already, by the view's id.
    """
    if len(session.views) == 1:  # the cameras of other films are placed with the lens that it has
        session = _with_first_lens(session, synchronised)
    if synchronised.pair is not None:
        lens = {"camera": synchronised.pair.film, "lens_source": "calibration"}
        view = view.model_copy(update=lens)
    first_keypoints, film_keypoints = keypoints
    best, *further = (
        _at_scale(session, view, film_keypoints, offset) for offset in synchronised.offsets
    )
    source: Literal["body", "file"] = "body" if synchronised.pair is None else "file"
    placed = _placed(view, best, further, source)
    if synchronised.pair is not None:
        placed = _measured(placed, synchronised.pair)
    if also is not None and placed.clock is not None:
        placed = placed.model_copy(update={"clock": placed.clock.model_copy(update={"also": also})})
    after = _with_view(session, placed)
    of_films = {**others, session.view.id: first_keypoints, view.id: film_keypoints}
    mended = mend_keyframes(after, of_films)
    # Feet stood on the floor by the first film alone: how far it is is another distance now.
    unfloored = mended.session.changed({"floor_m": None})
    film = FoundFilm(unfloored, film_keypoints, network, at, "")
    return AddedFilm(film, best, tuple(further), mended, synchronised.rate, synchronised.pair)


def _with_first_lens(session: Session, synchronised: Synchronised) -> Session:
    """The session with the lens that its first turned out to have: what is posed is seen as large
    as before."""
    lens, source = session.view.camera.zoomed(synchronised.offsets[0].camera.first_focal), "fitted"
    if synchronised.pair is not None:
        lens, source = synchronised.pair.first, "calibration"
    if lens == session.view.camera:
        return session
    return seen_as_before(session, session.changed({"camera": lens, "lens_source": source}))


def _at_scale(
    session: Session, view: View, keypoints: Keypoints, offset: FoundOffset
) -> FoundOffset:
    """An offset with its camera as far away as all that is posed says."""
    count = session.view.video.frame_count
    film = sightings_of(session, view, keypoints, view.camera)
    film = film.at(offset.clock, np.arange(count))
    posed = (*session.subject.keyframes, *session.subject.drafts[:: _every(session)])
    return replace(offset, camera=at_scale_of(offset.camera, film, joints_at(session, posed)))


def _every(session: Session) -> int:
    """One in how many drafts is asked."""
    return max(1, len(session.subject.drafts) // MOST_DRAFTS)


def _placed(
    view: View, best: FoundOffset, others: list[FoundOffset], source: Literal["body", "file"]
) -> View:
    """The view with its clock and its camera as found."""
    clock, placed = best.clock, best.camera
    T = placed.T_camera_first
    update = {
        "clock": Clock(
            begins=round(clock.begins, 4),
            rate=round(clock.rate, 8),
            sigma=round(best.sigma, 4) if 0 < best.sigma < np.inf else None,
            also=tuple(round(each.clock.begins, 4) for each in others),
        ),
        "placed": Placed(
            source=source,
            turn_sigma_rad=round(placed.sigma_rad, 6),
            place_sigma_m=round(placed.sigma_m, 4),
        ),
        "R_camera_world_wxyz": tuple(float(q) for q in quaternion_wxyz(T[:3, :3])),
        "p_camera_world": tuple(round(float(p), 6) for p in T[:3, 3]),
        "camera": view.camera.zoomed(placed.focal),
    }
    if placed.focal != 1.0:
        update["lens_source"] = "fitted"
    motion = view.camera_motion
    if motion is not None and motion.unscaled and placed.metres > 0:
        pieces = (motion.pieces[0].model_copy(update={"metres": float(f"{placed.metres:.7g}")}),)
        update["camera_motion"] = motion.model_copy(update={"pieces": pieces})
    return view.model_copy(update=update)


def _measured(view: View, pair: CalibratedPair) -> View:
    """The view with how far a calibration has its camera from the first one, where that is told."""
    apart_m = pair.apart_m(float(np.linalg.norm(view.p_camera_world)))
    if view.placed is None or apart_m is None:
        return view
    placed = view.placed.model_copy(update={"measured_m": round(apart_m, 4)})
    return view.model_copy(update={"placed": placed})


def _with_view(session: Session, view: View) -> Session:
    """The session with a further view."""
    return Session.model_validate(
        session.model_copy(update={"views": (*session.views, view)}).model_dump()
    )
