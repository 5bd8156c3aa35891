"""What a body is compared with answers for itself: a film, and observed surfaces."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.tracker.session import Session
from keypose.tracker.session.evidence import (
    ByEvidence,
    Evidence,
    FilmEvidence,
    SurfaceEvidence,
    surface_of,
)
from tests.app import surface_cases
from tests.film_or_surfaces import questions
from tests.tracker import session_cases

FILM = session_cases.session()
SURFACES = surface_cases.session(keyframes=(1, 3))
HERE = Path("my takes/session.json")


def about(of: Session, **video: Any) -> Session:
    """With its video said to be another."""
    return of.changed({"video": of.view.video.model_copy(update=video)})


def test_a_session_says_what_its_body_is_compared_with() -> None:
    assert type(FILM.evidence) is FilmEvidence
    assert type(SURFACES.evidence) is SurfaceEvidence


def test_segments_lie_between_keyframes_and_of_surfaces_reach_to_both_ends() -> None:
    assert FILM.evidence.spans((2, 5)) == ((2, 5),)
    assert SURFACES.evidence.spans((1, 3)) == ((0, 1), (1, 3), (3, 4))
    assert FILM.evidence.spans(()) == SURFACES.evidence.spans(()) == ()


def test_with_its_fewest_keyframes_evidence_has_a_segment_and_with_fewer_none() -> None:
    for of in (FILM, SURFACES):
        fewest = of.evidence.fewest_keyframes
        assert of.evidence.spans(range(fewest))
        assert not of.evidence.spans(range(fewest - 1))


def test_only_a_motion_of_surfaces_ends_where_nobody_posed_anything() -> None:
    assert FILM.evidence.open_ends((2, 5)) == ()
    assert SURFACES.evidence.open_ends((0, 3)) == (4,)
    assert SURFACES.evidence.open_ends((0, 3), reached=(0, 2, 3)) == (2,)


def test_the_mesh_that_moves_is_that_of_the_keyframe_named_or_of_the_first() -> None:
    assert FILM.model_keyframe is None
    assert SURFACES.evidence.model_keyframe(()) is None
    assert SURFACES.model_keyframe == SURFACES.subject.keyframes[0]
    named = surface_of(SURFACES).model_copy(update={"model_frame": 3})
    assert (
        SurfaceEvidence(SURFACES.view.video, named).model_keyframe(SURFACES.subject.keyframes)
        == (SURFACES.subject.keyframes[1])
    )


def test_the_name_of_that_keyframe_follows_it_to_another_frame() -> None:
    named = surface_of(SURFACES).model_copy(update={"model_frame": 3})
    evidence = SurfaceEvidence(SURFACES.view.video, named)
    assert evidence.with_key_moved(3, 2)["surface"].model_frame == 2
    assert evidence.with_key_moved(1, 2) == FILM.evidence.with_key_moved(4, 5) == {}


def test_a_film_s_file_gives_its_times_unless_the_session_has_a_rate_as_for_surfaces() -> None:
    of_file = np.arange(FILM.view.video.frame_count) / 30
    assert FILM.evidence.times_s(of_file) is of_file
    with pytest.raises(TypeError):
        FILM.evidence.times_s(None)
    times_s = about(FILM, recorded_fps=240.0).evidence.times_s(of_file)
    np.testing.assert_allclose(times_s, of_file / 8)
    assert SURFACES.evidence.times_s(None)[-1] == pytest.approx(4 / surface_of(SURFACES).fps)


def test_another_film_is_another_and_meshes_may_be_exported_again() -> None:
    film = about(FILM, fingerprint="sha256:a")
    assert not film.evidence.is_same(about(FILM, fingerprint="sha256:b").evidence)
    assert film.evidence.is_same(about(FILM, fingerprint="").evidence)
    assert SURFACES.evidence.is_same(about(SURFACES, fingerprint="sha256:b").evidence)
    assert not SURFACES.evidence.is_same(about(SURFACES, frame_count=4).evidence)


def test_paths_that_are_moved_are_the_video_s_and_the_cameras() -> None:
    read = surface_of(SURFACES).model_copy(update={"cameras": "cameras.json"})
    fields = SurfaceEvidence(SURFACES.view.video, read).with_paths(lambda path: f"../{path}")
    assert fields["surface"].cameras == "../cameras.json"
    assert fields["video"].path == f"../{SURFACES.view.video.path}"
    assert list(FILM.evidence.with_paths(str.upper)) == ["video"]


def test_words_say_what_it_is_what_is_done_and_how_to_do_it_again() -> None:
    film, surfaces = FILM.evidence.words, SURFACES.evidence.words
    assert (film.noun_with_is, surfaces.noun_with_is) == ("video is", "meshes are")
    assert (film.noun_was, surfaces.noun_was) == ("video was", "meshes were")
    assert film.command_line(HERE) == "keypose track 'my takes/session.json'"
    assert surfaces.command_line(HERE) == "keypose fit --session 'my takes/session.json'"


def test_to_surfaces_every_part_is_fitted_in_every_way() -> None:
    skeleton = session_cases.SKELETON
    assert FILM.evidence.dof_count(skeleton) == skeleton.dof_count
    assert SURFACES.evidence.dof_count(skeleton) == 3 + 3 * skeleton.part_count


def test_a_session_about_a_film_has_no_surface_to_be_asked_for() -> None:
    with pytest.raises(TypeError, match="not about surfaces"):
        surface_of(FILM)


def test_what_a_room_has_for_evidence_also_serves_what_is_derived_from_it(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    class Restored(FilmEvidence):
        """A film that somebody has mended."""

    known = ByEvidence({FilmEvidence: "pictures"})
    monkeypatch.setattr("keypose.tracker.session.evidence.EVIDENCE_KINDS", (Restored,))
    assert known.of(FILM) == "pictures"


def test_a_room_that_has_nothing_for_evidence_says_so() -> None:
    known = ByEvidence[str]({FilmEvidence: "pictures"})
    with pytest.raises(TypeError, match="SurfaceEvidence"):
        known.of(SURFACES)


def test_hardly_any_line_asks_whether_it_is_a_film_or_surfaces() -> None:
    assert len(list(questions())) < 20


def test_evidence_that_answers_nothing_is_none() -> None:
    with pytest.raises(TypeError, match="abstract"):
        Evidence(FILM.view.video)  # type: ignore[abstract]
