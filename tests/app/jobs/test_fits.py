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

from keypose.app.jobs.fits import FitJob
from keypose.app.jobs.messages import (
    FitOrder,
    JobFailed,
    JobFinished,
    PoseFitted,
    PoseOrder,
    Report,
    SizesFitted,
    SizesOrder,
)
from keypose.tracker.body.pose import Pose
from keypose.tracker.errors import VideoError
from keypose.tracker.session import Session
from tests.tracker import session_cases as cases

SESSION = cases.session()
CONTENT = SESSION.model_dump_json().encode()
POSE = SESSION.keyframes[0].pose(cases.SKELETON)


class Bench:
    """Its video is the path it was asked for."""

    def video(self, session: Session, path: str) -> str:
        if not path:
            raise VideoError("The video is gone.")
        return path


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


def reported(order: FitOrder, cancelled: Event | None = None) -> Report:
    """The one report that an order ends in."""
    reports: list[Report] = []
    FitJob(order, cancelled or Event(), reports.append).run(Bench())  # type: ignore[arg-type]
    (report,) = reports
    return report


def test_a_pose_is_fitted_by_the_other_keyframes(fits: Callable[..., None]) -> None:
    given: dict[str, Any] = {}

    def fit(video: Any, camera: Any, skeleton: Any, frame: int, pose: Any, keyposes: Any,
            tracked: Any, **more: Any) -> Found:  # fmt: skip
        given.update(video=video, frame=frame, keyposes=keyposes, tracked=tracked, **more)
        return Found()

    fits(fit)
    report = reported(PoseOrder(CONTENT, "v.mp4", 4, POSE, {3: POSE}, job=5))
    assert isinstance(report, PoseFitted)
    assert (report.job, report.found, report.words) == (5, True, "Right forearm moved 6 px.")
    assert given["video"] == "v.mp4"
    assert sorted(given["keyposes"]) == [0, 8]
    assert list(given["tracked"]) == [3]
    assert given["masks"] == SESSION.ignore_masks
    assert given["cancelled"]() is False


def test_what_the_picture_does_not_show_is_reported_as_such(fits: Callable[..., None]) -> None:
    fits(lambda *_, **__: Found(way="nothing", message="Nothing is seen."))
    report = reported(PoseOrder(CONTENT, "v.mp4", 4, POSE))
    assert isinstance(report, PoseFitted)
    assert not report.found


def test_sizes_are_fitted_to_all_keyframes(fits: Callable[..., None]) -> None:
    given: dict[str, Any] = {}

    def fit(video: Any, camera: Any, body: Any, keyposes: Any, focal: bool, **_: Any) -> Found:
        given.update(frames=sorted(keyposes), focal=focal)
        return Found(alone="sizes alone", unseen=("neck",))

    fits(fit)
    report = reported(SizesOrder(CONTENT, "v.mp4", focal=True, job=6))
    assert isinstance(report, SizesFitted)
    assert given == {"frames": [0, 4, 8], "focal": True}
    assert (report.error_px, report.alone, report.with_poses) == (6.2, "sizes alone", None)
    assert report.unseen == ("neck",)


def test_a_fit_that_was_cancelled_reports_nothing_it_found(fits: Callable[..., None]) -> None:
    cancelled = Event()

    def fit(*_: Any, cancelled: Callable[[], bool], **__: Any) -> Found:
        event.set()
        assert cancelled()
        return Found()

    event = cancelled
    fits(fit)
    assert reported(PoseOrder(CONTENT, "v", 4, POSE, job=3), cancelled) == JobFinished(3, True)


def test_a_video_that_is_gone_is_reported_in_a_sentence(fits: Callable[..., None]) -> None:
    fits(lambda *_, **__: Found())
    assert reported(PoseOrder(CONTENT, "", 4, POSE, job=3)) == JobFailed(3, "The video is gone.")


def test_a_fault_is_one_sentence_too(
    fits: Callable[..., None], capsys: pytest.CaptureFixture[str]
) -> None:
    def fit(*_: Any, **__: Any) -> Found:
        raise ZeroDivisionError

    fits(fit)
    report = reported(SizesOrder(CONTENT, "v", job=3))
    assert isinstance(report, JobFailed)
    assert "an internal error (ZeroDivisionError)" in report.words
    assert "Traceback" in capsys.readouterr().err


def test_poses_are_read_only_on_the_other_side() -> None:
    from multiprocessing import Pipe

    from keypose.app.jobs.wire import receive, send

    ours, theirs = Pipe()
    send(ours, PoseOrder(CONTENT, str(Path("v")), 4, POSE, {3: POSE}))
    order = receive(theirs)
    for pose in (order.pose, order.tracked[3]):
        assert not pose.Rs_parent_part.flags.writeable
        np.testing.assert_array_equal(pose.p_camera_root, POSE.p_camera_root)
