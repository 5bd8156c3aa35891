"""What stays ready from one job to the next."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from keypose.app.jobs.worker_cache import WorkerCache
from keypose.tracker.errors import SessionError, VideoError
from keypose.tracker.session import IgnoreMask, Session, TrackSettings
from tests.tracker import session_cases as cases

Place = tuple[Session, str]


@pytest.fixture
def place(tmp_path: Path) -> Place:
    return cases.session(), str(cases.write_frames(tmp_path / "frames"))


@pytest.fixture
def bench() -> Iterator[WorkerCache]:
    made = WorkerCache()
    yield made
    made.close()


def test_pictures_stay_prepared_when_keyframes_or_the_body_change(
    bench: WorkerCache, place: Place
) -> None:
    of, video = place
    one = bench.tracker(of, video)
    clip = one.loader((0, 4)).load(0, 4)
    fewer = of.changed({"keyframes": of.subject.keyframes[::2]})
    taller = of.subject.body.with_part(
        of.subject.body.parts[2].model_copy(update={"joint_m": (0.3, -0.2, 0.0)})
    )
    for session in (of, fewer, of.changed({"body": taller})):
        other = bench.tracker(session, video)
        assert tuple(other.spans) == session.spans
        assert other.loader((0, 4)) is one.loader((0, 4))
        assert other.skeleton.body == session.subject.body
    assert one.spans == [(0, 4), (4, 8)]
    assert one.skeleton.body == of.subject.body
    assert one.loader((0, 4)).load(0, 4) is clip


def test_the_body_is_laid_out_once(bench: WorkerCache, place: Place) -> None:
    of, video = place
    again = Session.model_validate_json(of.model_dump_json())
    one, other = bench.tracker(of, video), bench.tracker(again, video)
    assert one.skeleton is other.skeleton


def mask() -> IgnoreMask:
    return IgnoreMask(polygon=((0, 0), (9, 0), (9, 9)), first_frame=0, last_frame=3)


@pytest.mark.parametrize(
    "change",
    [
        {"camera": cases.CAMERA.model_copy(update={"fx": 61.0})},
        {"ignore_masks": (mask(),)},
        {"settings": cases.session().settings.model_copy(update={"static_camera": True})},
    ],
    ids=["camera", "mask", "static"],
)
def test_pictures_are_prepared_anew_for_another_camera_mask_or_plate(
    bench: WorkerCache, place: Place, change: dict[str, Any]
) -> None:
    of, video = place
    one = bench.tracker(of, video)
    other = bench.tracker(of.changed(change), video)
    assert other.loader((0, 4)) is not one.loader((0, 4))
    assert other.loader((0, 4)).video is one.loader((0, 4)).video


def test_another_video_at_the_same_place_is_opened(
    bench: WorkerCache, place: Place, tmp_path: Path
) -> None:
    of, video = place
    one = bench.tracker(of, video)
    shutil.rmtree(video)
    cases.write_frames(tmp_path / "frames", brightness=50)
    os.utime(video, (1, 1))
    other = bench.tracker(of, video)
    assert other.loader((0, 4)).video is not one.loader((0, 4)).video


def test_a_video_that_is_gone_is_reported_in_one_sentence(bench: WorkerCache, place: Place) -> None:
    of, video = place
    bench.tracker(of, video)
    shutil.rmtree(video)
    with pytest.raises(VideoError, match=r"\.$"):
        bench.tracker(of, video)


def test_a_segment_without_its_keyframe_is_refused(bench: WorkerCache, place: Place) -> None:
    of, video = place
    with pytest.raises(SessionError, match=r"^Frame 3 has no keyframe"):
        bench.tracker(of, video).run_segment((0, 3), TrackSettings(), lambda *_: None)
