"""Surfaces fitted by the page's worker: what stays ready, what is told, what is refused."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest

from keypose.app.jobs.fit_pose import FitPose, FoundPose
from keypose.app.jobs.fit_sizes import FitSizes
from keypose.app.jobs.job import Failed, Finished, Report
from keypose.app.jobs.progress import words_of
from keypose.app.jobs.rerun import save_found
from keypose.app.jobs.track import Track, _only_needed
from keypose.app.jobs.worker_cache import WorkerCache
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.errors import SessionError
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.operations.track import track_session
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.session.settings import Weights
from keypose.tracker.session.verdict import Verdict
from keypose.tracker.storage.files import load_session, open_video_of, save_session
from keypose.tracker.storage.results import Results, load_results, save_results, segment_keys
from keypose.tracker.storage.results import pose_at as pose_of
from keypose.tracker.storage.tracks import load_trajectory
from keypose.tracker.surface.fit import segment
from keypose.tracker.surface.fit.fitter import SurfaceFitter, options_of
from keypose.tracker.tracking.pool import SegmentStarted, TrackFinished
from keypose.tracker.video import Video
from tests.app import surface_cases as cases
from tests.app.jobs.job_cases import NUMBER, passes, reported, segments
from tests.app.serving import Keypose, Visitor
from tests.tracker import session_cases


@pytest.fixture
def bench() -> Iterator[WorkerCache]:
    made = WorkerCache()
    yield made
    made.close()


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return cases.write_session(tmp_path / "job")


def done(
    bench: WorkerCache,
    path: Path,
    session: Session,
    cancelled: Event | None = None,
    received: Callable[[Report], None] = lambda _: None,
) -> list[Report]:
    """All reports of a job over every segment of a session; `received` gets each of them."""
    wanted = tuple((*span, key) for span, key in segment_keys(session).items())
    job = Track.of(session, path.parent / "meshes", wanted, folder=path.parent)
    return reported(job, bench, cancelled, threads=2, received=received)


def fitted(bench: WorkerCache, path: Path, frame: int, pose: Pose) -> Any:
    """What comes of a fit here."""
    content = load_session(path).model_dump_json().encode()
    given = (content, str(path.parent / "meshes"), str(path.parent))
    (end,) = reported(FitPose(*given, frame, pose), bench)
    return end.result if isinstance(end, Finished) else end


def pose_at(frame: int) -> Pose:
    return Pose(cases.true_rotations()[frame], cases.true_roots()[frame])


def test_the_worker_counts_steps_and_gives_a_motion_of_the_whole_segment(
    bench: WorkerCache, path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(segment, "REPORT_S", 0.0)
    passed = passes(done(bench, path, load_session(path)))
    assert [report.number for report in passed] == [0, 1, 2, 3]
    assert words_of(passed[0]) == "step 1 of 4"
    assert passed[0].result.verdict is None
    assert {len(report.result.trajectory) for report in passed} == {cases.STEPS}
    assert np.isfinite(passed[0].result.trajectory.ps_camera_root).all()


@pytest.fixture
def stopped(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], dict[str, Any]]:
    """What makes `done` stop after so many steps."""
    monkeypatch.setattr(segment, "REPORT_S", 0.0)

    def after(steps: int) -> dict[str, Any]:
        cancelled = Event()

        def leave(report: Report) -> None:
            if any(one.number + 1 == steps for one in passes([report])):
                cancelled.set()

        return {"cancelled": cancelled, "received": leave}

    return after


def test_a_fit_that_is_stopped_keeps_the_steps_that_are_done_and_goes_on_after_them(
    bench: WorkerCache, path: Path, stopped: Callable[[int], dict[str, Any]]
) -> None:
    session = load_session(path)
    reports = done(bench, path, session, **stopped(2))
    assert reports[-1] == Finished(NUMBER, cancelled=True)
    (part,) = segments(reports)  # the step under way when it was stopped is done as well
    assert part.missing == 1
    assert part.verdict == Verdict.check("not_fitted", (4, 4))
    assert Results().with_result(part).wanted(session)
    again = done(bench, path, session)
    assert [one.number for one in passes(again)] == [3]
    assert again[-1] == Finished(NUMBER)
    (whole,) = segments(again)
    (at_once,) = segments(done(WorkerCache(), path, session))
    assert whole.trajectory.ps_camera_root.tobytes() == at_once.trajectory.ps_camera_root.tobytes()
    assert whole.diagnostics.residual.tobytes() == at_once.diagnostics.residual.tobytes()
    assert (whole.verdict, whole.missing) == (at_once.verdict, 0)


def test_what_a_stopped_fit_has_done_comes_back_from_the_disk_and_yields_to_more_only(
    bench: WorkerCache, path: Path, stopped: Callable[[int], dict[str, Any]]
) -> None:
    session = load_session(path)
    (more,) = segments(done(bench, path, session, **stopped(2)))
    (less,) = segments(done(WorkerCache(), path, session, **stopped(1)))
    assert (more.missing, less.missing) == (1, 2)
    save_session(save_results(session, path, Results().with_result(more)), path)
    session = load_session(path)
    assert session.subject.results is not None
    (summary,) = session.subject.results.segments
    assert summary.missing == more.missing
    loaded = load_results(session, path)
    (back,) = loaded.fitting(session).values()
    assert (back.missing, back.verdict) == (more.missing, more.verdict)
    assert back.trajectory.ps_camera_root.tobytes() == more.trajectory.ps_camera_root.tobytes()
    assert pose_of({(0, 4): back}, 3) is not None
    assert pose_of({(0, 4): back}, 4) is None
    assert loaded.wanted(session)
    assert loaded.states(session) == {(0, 4): "check"}
    assert loaded.with_result(less) is loaded
    save_found(session, path, [less])
    (kept,) = load_results(load_session(path), path).fitting(session).values()
    assert kept.missing == more.missing
    (whole,) = segments(done(bench, path, session))
    assert not loaded.with_result(whole).wanted(session)


def test_meshes_stay_open_and_the_model_laid_out_while_nothing_of_it_is_another(
    bench: WorkerCache, path: Path
) -> None:
    session = load_session(path)
    given = (str(path.parent / "meshes"), path.parent)
    one = bench.fitter(session, *given)
    video = bench.video(session, *given)
    again = Session.model_validate_json(session.model_dump_json())
    assert bench.fitter(again, *given) is one
    assert session.view.surface is not None
    other = session.view.surface.model_copy(update={"weights": "none"})
    assert bench.fitter(session.changed({"surface": other}), *given) is not one
    assert bench.video(session, *given) is video
    farther = session.view.surface.model_copy(update={"p_camera_surface": (0.0, 0.0, 9.0)})
    moved = bench.video(session.changed({"surface": farther}), *given)
    assert moved is not video


def test_meshes_that_were_exchanged_are_read_anew(bench: WorkerCache, path: Path) -> None:
    session = load_session(path)
    given = (str(path.parent / "meshes"), path.parent)
    video = bench.video(session, *given)
    (path.parent / "meshes").rename(path.parent / "old")
    cases.meshes(path.parent / "meshes")
    os.utime(path.parent / "meshes", ns=(1, 1))
    assert bench.video(session, *given) is not video


def test_a_mesh_that_was_mended_in_its_place_is_read_anew(bench: WorkerCache, path: Path) -> None:
    file = path.parent / "meshes" / "step_0002.ply"
    whole = file.read_bytes()
    file.write_bytes(b"")
    assert isinstance(fitted(bench, path, 2, pose_at(2)), Failed)
    file.write_bytes(whole)
    assert isinstance(fitted(bench, path, 2, pose_at(2)), FoundPose)


def test_a_mesh_less_in_the_folder_is_refused_for_every_step_would_be_another_one(
    bench: WorkerCache, path: Path
) -> None:
    session = load_session(path)
    bench.video(session, str(path.parent / "meshes"), path.parent)
    first, *_ = sorted((path.parent / "meshes").iterdir())
    first.unlink()
    report = done(bench, path, session)[-1]
    assert isinstance(report, Failed)
    assert "is not the one this session was made for (it has 4 frames instead of 5)" in report.words
    with pytest.raises(SessionError) as refused, open_video_of(session, path):
        pass
    assert report.words == str(refused.value)


def _moved_keyframe(session: Session, by_m: float) -> Session:
    at = pose_at(0)
    pose = Pose(at.Rs_parent_part, at.p_camera_root + np.array([by_m, 0.0, 0.0]))
    keyframe = Keyframe.of(Skeleton.of(session.subject.body), pose, 0, 0.0)
    others = tuple(k for k in session.subject.keyframes if k.frame)
    return session.changed({"keyframes": (keyframe, *others)})


@pytest.mark.parametrize(
    "wrong", ["a pose beside the mesh", "meshes ten times too small", "meshes in millimetres"]
)
def test_a_body_that_does_not_lie_in_the_surface_that_moves_with_it_is_reported_before_all_else(
    bench: WorkerCache, path: Path, wrong: str
) -> None:
    session = cases.session(keyframes=(0, 3))
    if wrong == "a pose beside the mesh":
        session = _moved_keyframe(session, 0.35)
    else:
        assert session.view.surface is not None
        units = "mm" if "millimetres" in wrong else "dm"
        at = session.subject.keyframes[0].pose(Skeleton.of(session.subject.body)).p_camera_root
        update = {"units": units, "p_camera_surface": tuple(map(float, at))}
        session = session.changed({"surface": session.view.surface.model_copy(update=update)})
    tracks = segments(done(bench, path, session))
    off = Verdict.check("body_off_surface", (0, 0))
    assert [track.verdict for track in tracks] == [off] * 2
    assert off.go == 0
    notes = [note for track in tracks for note in track.notes if "does not lie in" in note]
    assert len(notes) == 1
    assert notes[0].startswith("At frame 0 the body does not lie in the mesh that moves with it")


def test_a_body_posed_a_few_centimetres_off_its_mesh_is_not_said_to_lie_elsewhere(
    bench: WorkerCache, path: Path
) -> None:
    (track,) = segments(done(bench, path, _moved_keyframe(cases.session(), 0.05)))
    assert track.verdict is not None
    assert track.verdict.cause != "body_off_surface"
    assert not any("does not lie in" in note for note in track.notes)


@pytest.mark.parametrize("weights", ["contact", "none"])
def test_cameras_that_do_not_count_are_not_asked(
    bench: WorkerCache, path: Path, weights: Weights
) -> None:
    (path.parent / "rig.json").write_text("{}", encoding="utf-8")
    session = cases.session(cameras="rig.json", weights=weights)
    given = (str(path.parent / "meshes"), path.parent)
    assert len(bench.surfaces(session, *given).mesh(1).vertices) > 100
    reports = done(bench, path, session)
    assert reports[-1] == Finished(NUMBER)
    (failed,) = done(bench, path, cases.session(cameras="rig.json"))[-1:]
    assert isinstance(failed, Failed)
    assert "rig.json" in failed.words


def test_only_what_a_segment_needs_travels_with_its_order() -> None:
    session = cases.session(keyframes=(0, 1, 2, 3, 4))
    (*_, last) = ((*span, key) for span, key in segment_keys(session).items())
    kept = [keyframe.frame for keyframe in _only_needed(session, [last]).subject.keyframes]
    assert kept == [0, 3, 4]
    assert _only_needed(session, [last]).model_keyframe == session.model_keyframe


def test_a_pose_is_laid_onto_the_surface_of_its_frame(bench: WorkerCache, path: Path) -> None:
    truth = pose_at(2)
    turn = exp_rotation(np.array([[0.1, 0.0, 0.05], [-0.1, 0.0, 0.1], [0.0, 0.0, 0.12]]))
    rough = Pose(truth.Rs_parent_part @ turn, truth.p_camera_root + np.array([0.05, -0.04, 0.03]))
    report = fitted(bench, path, 2, rough)
    assert isinstance(report, FoundPose)
    assert report.found
    assert np.linalg.norm(report.pose.p_camera_root - truth.p_camera_root) < 0.025
    assert report.words.startswith("Arm")
    assert "moved" in report.words


@pytest.mark.parametrize("keyed", [True, False])
def test_a_first_pose_is_laid_into_its_mesh_by_the_bodys_own_solids(
    bench: WorkerCache, path: Path, keyed: bool
) -> None:
    if not keyed:
        session = load_session(path).changed({"keyframes": (), "results": None})
        save_session(session, path)
    truth = pose_at(0)
    turn = exp_rotation(np.array([[0.1, 0.0, 0.1], [-0.1, 0.0, 0.1], [0.05, 0.0, 0.15]]))
    rough = Pose(truth.Rs_parent_part @ turn, truth.p_camera_root + np.array([0.08, -0.05, 0.05]))
    report = fitted(bench, path, 0, rough)
    assert isinstance(report, FoundPose)
    assert np.linalg.norm(report.pose.p_camera_root - truth.p_camera_root) < 0.04
    assert "moved" in report.words


def test_a_mesh_that_cannot_be_used_fits_nothing_and_says_why(
    bench: WorkerCache, path: Path
) -> None:
    (path.parent / "meshes" / "step_0002.ply").unlink()
    report = fitted(bench, path, 2, pose_at(2))
    assert isinstance(report, Failed)
    assert "Step 2 is missing" in report.words


def test_sizes_are_not_fitted_to_surfaces(bench: WorkerCache, path: Path) -> None:
    content = load_session(path).model_dump_json().encode()
    (report,) = reported(FitSizes(content, str(path.parent / "meshes"), ""), bench)
    assert isinstance(report, Failed)
    assert report.words.startswith("Sizes are fitted to pictures")


def test_a_session_without_keyframes_cannot_be_fitted(path: Path) -> None:
    none = cases.session(keyframes=())
    with pytest.raises(SessionError, match="one at least is needed"):
        SurfaceFitter(none, steps=None)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("chosen", "expected"),
    [
        ({}, (True, True, 1.0, False)),
        ({"weights": "contact"}, (True, False, 1.0, False)),
        ({"weights": "photo"}, (False, True, 1.0, False)),
        ({"weights": "none", "distance": "point", "binding": "smooth"}, (False, False, 0.0, True)),
    ],
)
def test_what_a_session_says_is_what_is_done(
    chosen: dict[str, str], expected: tuple[bool, bool, float, bool]
) -> None:
    surface = cases.session(**chosen).view.surface  # type: ignore[arg-type]
    assert surface is not None
    options = options_of(surface)
    assert (options.contact, options.photo, options.plane, options.smooth) == expected


def test_the_page_fits_surfaces_and_speaks_of_fitting(tmp_path: Path) -> None:
    path = cases.write_session(tmp_path / "job")
    keypose = Keypose(str(path), "--workspace", str(tmp_path / "workspace"))
    try:
        visitor = Visitor(keypose)
        assert visitor.seen["file"]["frames"] == cases.STEPS
        visitor.do(do="track", what="all")
        visitor.until(lambda: visitor.seen["job"]["state"] == "done", seconds=300)
        assert visitor.seen["job"]["title"] == "Fitted 0–4"
        visitor.do(do="track", what="changed")
        assert visitor.refusal() == "All segments are fitted and up to date."
        visitor.leave()
    finally:
        code, words = keypose.end()
    assert code == 0, words
    found = load_trajectory(load_session(path), path)
    assert np.abs(found.ps_camera_root - cases.true_roots()).max() < 0.03


def test_a_program_of_ones_own_fits_by_the_same_road(path: Path) -> None:
    session = load_session(path)
    with open_video_of(session, path) as video:
        events = list(track_session(session, video))
    (started, *_, finished) = events
    assert isinstance(started, SegmentStarted)
    assert isinstance(finished, TrackFinished)
    roots = finished.result.trajectory.ps_camera_root
    assert np.abs(roots - cases.true_roots()).max() < 0.03
    assert len(finished.result.segments) == 1


def test_surfaces_opened_as_a_film_of_images_are_refused(path: Path, tmp_path: Path) -> None:
    folder = session_cases.write_frames(tmp_path / "frames")
    with (
        Video.open(folder) as video,
        pytest.raises(SessionError, match="open them with open_video_of"),
    ):
        list(track_session(load_session(path), video))
