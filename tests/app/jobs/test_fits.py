"""One order to fit, with fits that do as the test says."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from threading import Event
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from keypose.app.jobs.fit_pose import FitPose, FoundPose
from keypose.app.jobs.fit_sizes import FitSizes
from keypose.app.jobs.job import Failed, Finished, Job, Report
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import VideoError
from keypose.tracker.session import Session
from tests.app.editor.desk import desk
from tests.app.film_beside_cases import saved_in, seen_of, with_film
from tests.app.jobs import job_cases
from tests.app.jobs.job_cases import NUMBER
from tests.tracker import session_cases as cases

SESSION = cases.session()
CONTENT = SESSION.model_dump_json().encode()
POSE = SESSION.subject.keyframes[0].pose(cases.SKELETON)


class Bench:
    """Its video is the path it was asked for."""

    def video(self, session: Session, path: str) -> str:
        if not path:
            raise VideoError("The video is gone.")
        return path

    def keypoints(self, session: Session, folder: object) -> None:
        """It has none."""


@dataclass
class Found:
    pose: Pose = POSE
    way: str = "neighbours"
    message: str = "Right forearm moved 6 px."
    error_px: float = 6.2
    alone: Any = None
    with_poses: Any = None
    unseen: tuple[str, ...] = ()


@pytest.fixture
def fits(monkeypatch: pytest.MonkeyPatch) -> Callable[[Callable[..., Any]], None]:
    """Both fits replaced."""

    def replaced(fit: Callable[..., Any]) -> None:
        for place, name in (("pose", "fit_pose_to_picture"), ("sizes", "fit_sizes")):
            module = ModuleType(name)
            setattr(module, name, fit)
            monkeypatch.setitem(sys.modules, f"keypose.tracker.fitting.{place}", module)

    return replaced


def reported(job: Job, cancelled: Event | None = None) -> Report:
    """The one report that a job ends in."""
    (report,) = job_cases.reported(job, Bench(), cancelled)
    return report


def found(job: Job) -> Any:
    """What a job finds."""
    report = reported(job)
    assert isinstance(report, Finished)
    return report.result


def test_of_two_films_a_pose_is_fitted_by_both_and_says_by_how_much(
    fits: Callable[..., None], tmp_path: Path
) -> None:
    fits(lambda *args, **more: pytest.fail("The first film alone was asked."))
    doc = with_film(desk().doc)
    skeleton = Skeleton.of(doc.subject.body)
    true = doc.subject.keyframes[0].pose(skeleton)
    nearer = Pose(true.Rs_parent_part, 0.97 * true.p_camera_root)  # looks the same in the first
    doc = saved_in(tmp_path, doc, seen_of(doc, true))
    content = doc.model_dump_json().encode()
    fit = found(FitPose(content, "film.mp4", str(tmp_path), 10, nearer))
    assert fit.found
    assert fit.words.startswith("Fitted to what 2 films show: joints moved by 1")
    np.testing.assert_allclose(fit.pose.p_camera_root, true.p_camera_root, atol=0.03)


def test_a_pose_that_the_other_film_does_not_show_is_fitted_by_the_first_alone(
    fits: Callable[..., None], tmp_path: Path
) -> None:
    fits(lambda *args, **more: Found(message="By one film."))
    doc = with_film(desk().doc)
    pose = doc.subject.keyframes[0].pose(Skeleton.of(doc.subject.body))
    doc = saved_in(tmp_path, doc, seen_of(doc, pose))
    content = doc.model_dump_json().encode()
    before_it_begins = FitPose(content, "film.mp4", str(tmp_path), 2, pose)
    assert found(before_it_begins).words == "By one film."


def test_a_pose_is_fitted_by_the_other_keyframes(fits: Callable[..., None]) -> None:
    given: dict[str, Any] = {}

    def fit(video: Any, camera: Any, skeleton: Any, frame: int, pose: Any, keyposes: Any,
            tracked: Any, **more: Any) -> Found:  # fmt: skip
        given.update(video=video, frame=frame, keyposes=keyposes, tracked=tracked, **more)
        return Found()

    fits(fit)
    pose = found(FitPose(CONTENT, "v.mp4", "", 4, POSE, {3: POSE}))
    assert isinstance(pose, FoundPose)
    assert (pose.found, pose.words) == (True, "Right forearm moved 6 px.")
    assert given["video"] == "v.mp4"
    assert sorted(given["keyposes"]) == [0, 8]
    assert list(given["tracked"]) == [3]
    assert given["masks"] == SESSION.view.ignore_masks
    assert given["cancelled"]() is False


def test_what_the_picture_does_not_show_is_reported_as_such(fits: Callable[..., None]) -> None:
    fits(lambda *_, **__: Found(way="nothing", message="Nothing is seen."))
    assert not found(FitPose(CONTENT, "v.mp4", "", 4, POSE)).found


def test_sizes_are_fitted_to_all_keyframes(fits: Callable[..., None]) -> None:
    given: dict[str, Any] = {}

    def fit(video: Any, camera: Any, body: Any, keyposes: Any, focal: bool, **_: Any) -> Found:
        given.update(frames=sorted(keyposes), focal=focal)
        return Found(alone="sizes alone", unseen=("neck",))

    fits(fit)
    sizes = found(FitSizes(CONTENT, "v.mp4", "", focal=True))
    assert given == {"frames": [0, 4, 8], "focal": True}
    assert (sizes.error_px, sizes.alone, sizes.with_poses) == (6.2, "sizes alone", None)
    assert sizes.unseen == ("neck",)


def test_a_fit_that_was_cancelled_reports_nothing_it_found(fits: Callable[..., None]) -> None:
    cancelled = Event()

    def fit(*_: Any, cancelled: Callable[[], bool], **__: Any) -> Found:
        event.set()
        assert cancelled()
        return Found()

    event = cancelled
    fits(fit)
    assert reported(FitPose(CONTENT, "v", "", 4, POSE), cancelled) == Finished(
        NUMBER, cancelled=True
    )


def test_a_video_that_is_gone_is_reported_in_a_sentence(fits: Callable[..., None]) -> None:
    fits(lambda *_, **__: Found())
    gone = Failed(NUMBER, "The video is gone.")
    assert reported(FitPose(CONTENT, "", "", 4, POSE)) == gone


def test_a_fault_is_one_sentence_too(
    fits: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    def fit(*_: Any, **__: Any) -> Found:
        raise ZeroDivisionError

    fits(fit)
    report = reported(FitSizes(CONTENT, "v", ""))
    assert isinstance(report, Failed)
    assert "an internal error (ZeroDivisionError)" in report.words
    assert "Traceback" in capsys.readouterr().err


def test_poses_are_read_only_on_the_other_side() -> None:
    from multiprocessing import Pipe

    from keypose.app.jobs.wire import receive, send

    ours, theirs = Pipe()
    send(ours, FitPose(CONTENT, "v", "", 4, POSE, {3: POSE}))
    order = receive(theirs)
    for pose in (order.pose, order.tracked[3]):
        assert not pose.Rs_parent_part.flags.writeable
        np.testing.assert_array_equal(pose.p_camera_root, POSE.p_camera_root)
