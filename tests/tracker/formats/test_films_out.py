"""Files say how far joints lie from where each of several films shows them, and which see them."""

from __future__ import annotations

import csv
import io
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import ezc3d
import numpy as np
import pytest

from keypose.app.words.films import film_errors_words
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.films.cameras import joints_of_pose
from keypose.tracker.films.errors import FilmErrors
from keypose.tracker.formats.csv import frames_csv
from keypose.tracker.formats.marker_files import c3d, trc
from keypose.tracker.formats.npz import npz
from keypose.tracker.formats.recording import MarkerSetName, Recording
from keypose.tracker.formats.sampling import at_rate
from keypose.tracker.geometry.film_clock import sampled
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.operations.films import seen_in_films
from keypose.tracker.operations.seen_by import seen_by
from keypose.tracker.session import Session
from keypose.tracker.session.views import Clock
from tests.app.film_beside_cases import ID, with_film
from tests.tracker.formats import recordings

LATE = 4
BESIDE_PX = 5.0
HIDDEN = JOINTS.index("left_wrist")
ELBOW = JOINTS.index("right_elbow")


@cache
def two_films() -> tuple[Session, dict[str, Keypoints]]:
    """A session whose second film began four frames later, and puts all joints (3, 4) px aside."""
    session = with_film(recordings.session("person"), Clock(begins=float(LATE)))
    motion, skeleton = recordings.trajectory("person"), Skeleton.of(session.subject.body)
    count = session.view.video.frame_count
    frames = np.clip(np.arange(count), motion.first_frame, motion.last_frame)
    joints = np.stack([joints_of_pose(skeleton, motion.pose(int(frame))) for frame in frames])
    first, film = session.views
    T = film.T_camera_world
    there = sampled(joints, np.minimum(np.arange(count) + LATE, count - 1.0))
    there = there @ T[:3, :3].T + T[:3, 3]
    seen = np.ones((count, len(JOINTS)))
    hidden = seen.copy()
    hidden[:, HIDDEN] = 0.0
    return session, {
        first.id: Keypoints(0, JOINTS, first.camera.project(joints), seen),
        film.id: Keypoints(0, JOINTS, film.camera.project(there) + np.array([3.0, 4.0]), hidden),
    }


def errors() -> tuple[FilmErrors, ...]:
    session, keypoints = two_films()
    motion, skeleton = recordings.trajectory("person"), Skeleton.of(session.subject.body)
    frames = np.arange(motion.first_frame, motion.last_frame + 1)
    names = {view.id: f"{view.id}.mp4" for view in session.views}
    return seen_by(session, keypoints, frames, motion.transforms(skeleton)).errors(names)


def filmed(marker_set: MarkerSetName = "keypose") -> Recording:
    return replace(
        recordings.recording("person", without=(1,)), films=errors(), marker_set=marker_set
    )


def test_errors_are_those_of_each_film_where_it_ran_and_saw_the_joint() -> None:
    first, film = errors()
    assert first.median_px == pytest.approx(0.0, abs=1e-6)
    assert film.median_px == pytest.approx(BESIDE_PX)
    assert np.isnan(film.px[:LATE]).all(), "it had not begun"
    assert np.isnan(film.px[:, HIDDEN]).all()
    assert np.isfinite(film.px[LATE:, ELBOW]).all()
    session, keypoints = two_films()
    (_, sight) = seen_in_films(session, keypoints, LATE + 3)
    depth = sight.camera.depth(
        joints_of_pose(
            Skeleton.of(session.subject.body), recordings.trajectory("person").pose(LATE + 3)
        )
        @ sight.T_film_first[:3, :3].T
        + sight.T_film_first[:3, 3]
    )
    expected_m = BESIDE_PX * depth[ELBOW] / sight.camera.fx
    assert film.aside_m[LATE + 3, ELBOW] == pytest.approx(expected_m, rel=0.03)


def test_words_name_every_film_that_shows_a_joint() -> None:
    first, film = errors()
    assert film_errors_words((replace(first, px=first.px + 12.4), film)) == (
        f"Joints lie 12 px from where view.mp4 shows them and 5.0 px in {ID}.mp4, in the median."
    ).replace("view.mp4", f"{two_films()[0].view.id}.mp4")
    nothing = replace(film, px=np.full_like(film.px, np.nan))
    assert film_errors_words((nothing,)) == ""


def read(recording: Recording, folder: Path) -> Any:
    (folder / "read.c3d").write_bytes(c3d(recording))
    return ezc3d.c3d(str(folder / "read.c3d"))


@pytest.mark.parametrize(
    ("marker_set", "elbow", "wrist", "unknown"),
    [
        ("keypose", "right_forearm", "left_hand", "head"),
        ("halpe26", "RElbow", "LWrist", "Head"),
    ],
)
def test_c3d_has_the_films_residual_and_which_of_them_see_a_marker(
    marker_set: MarkerSetName, elbow: str, wrist: str, unknown: str, tmp_path: Path
) -> None:
    made = filmed(marker_set)
    file = read(made, tmp_path)
    labels = file["parameters"]["POINT"]["LABELS"]["value"]
    marks = file["data"]["meta_points"]
    residual, masks = marks["residuals"][0], marks["camera_masks"]
    tracked = made.tracks.tracked
    rows = np.flatnonzero(tracked)[LATE + 1 :]
    elbow_at, wrist_at, unknown_at = (labels.index(name) for name in (elbow, wrist, unknown))
    assert masks[:2, elbow_at, rows].all()
    assert not masks[2:].any()
    assert masks[0, wrist_at, rows].all()
    assert not masks[1, wrist_at].any(), "the second film does not see it"
    assert not masks[:, unknown_at].any()
    assert (residual[unknown_at, rows] == 0).all()
    expected = np.nanmean([film.aside_m[:, ELBOW] for film in made.films], axis=0) * 1000
    np.testing.assert_allclose(residual[elbow_at, rows], expected[rows], atol=0.51)
    assert (residual[elbow_at, ~tracked] == -1).all()
    assert not masks[:, elbow_at, ~tracked].any()
    names = [film.name for film in made.films]
    assert file["parameters"]["KEYPOSE"]["FILMS"]["value"] == names


def test_a_joint_that_lies_far_aside_has_the_largest_residual_there_is_and_its_films(
    tmp_path: Path,
) -> None:
    first, film = errors()
    far = replace(film, aside_m=film.aside_m + 3.0)
    file = read(replace(filmed(), films=(first, *(far,) * 7)), tmp_path)
    at = file["parameters"]["POINT"]["LABELS"]["value"].index("right_forearm")
    marks = file["data"]["meta_points"]
    assert marks["residuals"][0, at, LATE + 1] == 255
    assert marks["camera_masks"][:, at, LATE + 1].all(), "seven of eight films have a bit"


def test_an_archive_has_every_films_error_and_how_many_see_a_joint() -> None:
    made = filmed()
    with np.load(io.BytesIO(npz(made))) as arrays:
        assert arrays["film_names"].tolist() == [film.name for film in made.films]
        assert arrays["film_joint_names"].tolist() == list(JOINTS)
        np.testing.assert_array_equal(arrays["film_error_px"][1], made.films[1].px)
        assert arrays["films_seeing"][LATE + 1, ELBOW] == 2
        assert arrays["films_seeing"][LATE + 1, HIDDEN] == 1
        assert arrays["films_seeing"][0, ELBOW] == 1


def test_the_table_of_frames_has_a_column_of_each_film_and_of_each_joint() -> None:
    rows = list(csv.DictReader(io.StringIO(frames_csv(filmed()), newline="")))
    row = rows[LATE + 2]
    assert float(row["film_1_error_px"]) == pytest.approx(0.0, abs=1e-5)
    assert float(row["film_2_error_px"]) == pytest.approx(BESIDE_PX, abs=1e-5)
    assert (float(row["right_elbow_films"]), float(row["left_wrist_films"])) == (2, 1)
    assert rows[0]["film_2_error_px"] == ""


def test_at_a_rate_of_its_own_a_pose_has_the_errors_of_the_nearest_frame() -> None:
    made = at_rate(filmed(), 50.0)
    nearest = np.round(made.film_frames).astype(int) - made.films[0].first_frame
    np.testing.assert_array_equal(made.errors_by_film[1].px, made.films[1].px[nearest])
    assert len(made.errors_by_film[0].px) == len(made)


def test_one_film_leaves_every_file_as_it_is() -> None:
    made = recordings.recording("person")
    assert made.errors_by_film == ()
    assert b"FILMS" not in c3d(made)
    assert "film_1_error_px" not in frames_csv(made)
    with np.load(io.BytesIO(npz(made))) as arrays:
        assert "film_error_px" not in arrays
    assert trc(replace(made, films=errors())) == trc(made), "TRC has no place for it"
