"""A third kind of evidence, which only its own class knows, is understood wherever it is asked for.

Two films of one motion stand for it: as long as nothing of its own is wanted, a room needs no
change, and where something is, it is one entry in that room's table.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from keypose.app.editor.advice import next_step, why_nothing_to_do
from keypose.app.export.report.report import report_html
from keypose.app.jobs.rerun import require_trackable
from keypose.app.state.app_state import AppState
from keypose.app.store.sections import Sections
from keypose.tracker.errors import SessionError
from keypose.tracker.operations.track import track_session
from keypose.tracker.session import Session
from keypose.tracker.session.evidence import (
    EVIDENCE_KINDS,
    ByEvidence,
    EvidenceSource,
    FilmEvidence,
)
from keypose.tracker.storage import evidence as storage
from keypose.tracker.storage.edit_history import is_same_film, mark_of
from keypose.tracker.storage.evidence.files import FilmFiles
from keypose.tracker.storage.files import load_session, open_video_of
from keypose.tracker.storage.fingerprints import open_ends, setup_hash
from keypose.tracker.storage.outdated import outdated_words
from keypose.tracker.storage.results import segment_keys
from keypose.tracker.storage.tracks import load_tracks, save_result
from keypose.tracker.tracking.pool import TrackFinished
from tests.app.editor.desk import desk
from tests.tracker import session_cases as cases


class TwoFilms(FilmEvidence):
    """Two films of one motion, the second named in a field that no room knows."""

    words = replace(
        FilmEvidence.words,
        noun="films",
        is_plural=True,
        verb="follow",
        doing="following",
        done="followed",
        unit="round",
        setup="body or either film",
        file="pair of films",
        command="follow",
    )
    run_fields = ("second",)

    @classmethod
    def of(cls, session: EvidenceSource) -> TwoFilms | None:
        return cls(session.view.video) if "second" in (session.model_extra or {}) else None


@pytest.fixture(autouse=True)
def _known(monkeypatch: pytest.MonkeyPatch) -> None:
    """The one place where a kind of evidence is made known."""
    monkeypatch.setattr(
        "keypose.tracker.session.evidence.EVIDENCE_KINDS", (TwoFilms, *EVIDENCE_KINDS)
    )


def with_second(session: Session) -> Session:
    return Session.model_validate({**session.model_dump(mode="json"), "second": "other.mp4"})


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Such a session on disk."""
    written = cases.write_session(tmp_path / "take")
    cases.altered(written, lambda data: data.update(second="other.mp4"))
    return written


def test_its_session_is_read_and_knows_itself_again(path: Path) -> None:
    session = load_session(path)
    assert type(session.evidence) is TwoFilms
    assert is_same_film(session, session)
    assert mark_of(session) != mark_of(cases.session())
    with open_video_of(session, path) as video:
        assert video.info.frame_count == cases.FRAMES


def test_its_segments_keys_and_setup_are_those_of_what_it_is_derived_from() -> None:
    film, two = cases.session(), with_second(cases.session())
    assert segment_keys(two) == segment_keys(film)
    assert setup_hash(two) == setup_hash(film)
    assert open_ends(two) == ()


def test_it_is_tracked_as_what_it_is_derived_from(path: Path) -> None:
    session = load_session(path)
    with open_video_of(session, path) as video:
        events = list(track_session(session, video, segments=[0], cancelled=lambda: True))
    assert isinstance(events[-1], TrackFinished)


def test_storage_speaks_its_words(path: Path) -> None:
    session = load_session(path)
    with pytest.raises(SessionError, match="has not been followed yet: run `keypose follow "):
        load_tracks(session, path)
    cases.altered(path, lambda data: data["video"].update(path="gone"))
    with pytest.raises(SessionError, match=r"The pair of films .* is missing"):
        open_video_of(load_session(path), path)


def test_what_it_was_tracked_for_is_named_in_its_words(path: Path) -> None:
    tracked = save_result(load_session(path), path, cases.result())
    other = tracked.changed({"camera": cases.CAMERA.model_copy(update={"fx": 61.0})})
    message = outdated_words(other, load_tracks(tracked, path))
    assert message == "the tracked motion is out of date (body or either film have changed)."


def test_the_page_speaks_its_words() -> None:
    edit = desk()
    reported = Sections().changed(AppState(edit=replace(edit, doc=with_second(edit.doc))))
    assert {segment["words"] for segment in reported["segments"]} == {"Not followed"}
    assert reported["surface"] is None


def test_advice_is_that_of_what_it_is_derived_from() -> None:
    film = cases.session()
    two = with_second(film)
    assert next_step((0, 4, 8), two, {}) == next_step((0, 4, 8), film, {})
    assert why_nothing_to_do(two) == why_nothing_to_do(film)


def test_without_keyframes_it_is_refused_before_any_work(path: Path) -> None:
    bare = load_session(path).changed({"keyframes": ()})
    with pytest.raises(SessionError, match="has no keyframes"):
        require_trackable(bare, path)


def test_a_report_is_written_of_it(path: Path) -> None:
    assert b"64 \xc3\x97 48 pixels" in report_html(load_session(path), path)


def test_what_is_its_own_is_one_entry_of_a_room_s_table(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Renamed(FilmFiles):
        def fingerprint_at(self, session: Session, path: Path) -> str | None:
            return session.view.video.fingerprint if path.name == "both" else None

    entries: dict[Any, Any] = {TwoFilms: Renamed(), FilmEvidence: FilmFiles()}
    monkeypatch.setattr(storage, "FILES", ByEvidence(entries))
    (path.parent / "frames").rename(path.parent / "both")
    cases.altered(path, lambda data: data["video"].update(fingerprint="sha256:pair"))
    with pytest.raises(SessionError, match="fingerprint differs"):  # it was found and opened
        open_video_of(load_session(path), path)
