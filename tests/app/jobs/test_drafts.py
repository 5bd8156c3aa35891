"""One order to draft a clip: its progress, its end, and how it is left."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.app.document.new import new_session
from keypose.app.jobs.draft import DraftClip, DraftReporter, drafted
from keypose.app.jobs.job import Failed, Finished, Progress
from keypose.tracker.fitting.draft import DraftProgress, clip
from keypose.tracker.keypoints import model_files
from keypose.tracker.session import Session
from keypose.tracker.video import Video
from tests.app.jobs.job_cases import NUMBER, reported_until
from tests.tracker.keypoints.keypoint_cases import BALANCE, BOX

VIDEO = BALANCE / "balance.mp4"


@pytest.fixture(scope="module")
def content() -> bytes:
    """A session of the film, as an order holds it."""
    with Video.open(VIDEO) as video:
        return new_session(video, Path("session.json").absolute()).model_dump_json().encode()


def order(content: bytes, box: tuple[float, float, float, float] = BOX) -> DraftClip:
    return DraftClip(content, str(VIDEO), "", 0, box, (0, 4), proportions=True)


def test_a_clip_is_drafted_and_its_progress_rises(content: bytes) -> None:
    *progress, end = reported_until(order(content), None)
    assert isinstance(end, Finished)
    draft, network, detected = end.result[0]
    assert detected is None
    assert sorted(draft.poses) == list(range(5))
    assert network
    shares = [report.share for report in progress if isinstance(report, Progress) and report.words]
    assert len(shares) == len(progress)
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1)


@pytest.mark.parametrize(
    ("least_fps", "still", "looked", "masked"),
    [
        (1.0, True, {0, 2, 4, 6, 8}, False),
        (1000.0, True, {*range(9)}, False),
        (1.0, False, {*range(9)}, True),  # each frame's mask judges what is tracked
    ],
)
def test_a_quick_film_is_drafted_from_every_second_frame_where_no_mask_is_needed(
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    least_fps: float,
    still: bool,
    looked: set[int],
    masked: bool,
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(model_files, "LEAST_SKIPPED_FPS", least_fps)
    seen: set[int] = set()
    frame = Video.frame

    def shown(self: Video, number: int) -> NDArray[np.uint8]:
        seen.add(number)
        return frame(self, number)

    with Video.open(VIDEO) as video:
        session = new_session(video, Path("session.json").absolute())
        settings = session.settings.model_copy(update={"static_camera": still})
        session = session.changed({"settings": settings})
        monkeypatch.setattr(Video, "frame", shown)
        monkeypatch.setattr(clip, "people_changes", lambda *given, **named: [()])
        report: dict[str, Any] = {"proportions": True, "report": lambda progress: None}
        found = drafted(session, video, 0, BOX, (0, 8), **report)
    assert seen == looked
    assert sorted(found.draft.poses) == list(range(9))
    masks = found.draft.keypoints.masks
    assert (masks is not None) is masked
    if masks is not None:
        assert all(mask == mask.outlined() for mask in masks if mask is not None)


def test_a_cancelled_draft_reports_nothing_it_found(content: bytes) -> None:
    *progress, end = reported_until(order(content), 2)
    assert end == Finished(NUMBER, cancelled=True)
    assert len(progress) == 2


@pytest.mark.parametrize("at", [0, 39], ids=["forward", "backward"])
def test_a_draft_that_is_cancelled_later_keeps_what_the_network_has_seen(
    content: bytes,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
    at: int,
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    job = DraftClip(content, str(VIDEO), "", at, BOX, (0, 39), proportions=True)
    *progress, end = reported_until(job, 30)
    assert isinstance(end, Finished)
    assert not end.cancelled
    first, last = end.result[0].detected
    assert first <= at <= last
    assert 16 <= last - first + 1 < 40
    assert {*end.result[0].draft.poses} <= {*range(first, last + 1)}
    assert len(end.result[0].draft.poses) > 10
    shares = [report.share for report in progress if isinstance(report, Progress)]
    assert shares == sorted(shares)


def test_so_does_a_draft_of_two_people_who_are_followed_together(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    film, width = twice(tmp_path / "film", 40)
    with Video.open(film) as video:
        begun = new_session(video, film / "session.json").model_dump_json().encode()
    left, top, right, bottom = BOX
    beside = left + width, top, right + width, bottom
    job = DraftClip(begun, str(film), "", 0, BOX, (0, 39), proportions=True, others=(beside,))
    *_, end = reported_until(job, 20)
    assert isinstance(end, Finished)
    assert not end.cancelled
    for draft, _, (first, last) in end.result:
        assert first == 0
        assert 15 <= last < 39
        assert sorted(draft.poses) == list(range(last + 1))
    assert len(end.result) == 2


def twice(folder: Path, frames: int) -> tuple[Path, int]:
    """A folder of pictures that show the film beside itself, and the width of the film."""
    folder.mkdir()
    with Video.open(VIDEO) as video:
        for number in range(frames):
            picture = video.frame(number)[..., ::-1]
            cv2.imwrite(str(folder / f"{number:04}.png"), np.hstack([picture, picture]))
        return folder, video.info.width


def test_a_box_with_nobody_in_it_is_one_sentence(content: bytes) -> None:
    end = reported_until(order(content, (0.0, 0.0, 60.0, 60.0)), None)[-1]
    assert isinstance(end, Failed)
    assert end.words.startswith("No person was found at frame 0:")


def test_a_network_that_is_not_here_is_one_sentence_that_says_how_to_add_it(
    content: bytes, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    session = Session.model_validate_json(content)
    settings = session.settings.model_copy(update={"network": "mine"})
    named = session.changed({"settings": settings}).model_dump_json().encode()
    (end,) = reported_until(order(named), None)
    assert isinstance(end, Failed)
    assert end.words.endswith("`keypose models add mine --from FILE --sha256 DIGEST`.")


@pytest.mark.parametrize("frames", [40, 9_600, 120_000])
def test_progress_of_a_draft_is_told_every_ten_frames_however_long_the_film(frames: int) -> None:
    told: list[int] = []
    reporter = DraftReporter(lambda progress: told.append(progress.done), lambda: False)
    for done in range(frames + 1):
        reporter(DraftProgress("keypoints", done, frames))
    assert told[0] == 0
    assert told[-1] == frames
    assert max(np.diff(told)) <= 10
    assert len(told) <= max(101, frames // 10 + 2)
