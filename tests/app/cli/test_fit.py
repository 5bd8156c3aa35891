"""`keypose fit`: a motion by observed surfaces, kept and told as a tracked one is."""

from __future__ import annotations

import csv
import hashlib
import json
import shutil
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import trimesh

from keypose.app.cli.main import main
from keypose.tracker.geometry.rotations import log_rotation, transpose
from keypose.tracker.storage.files import load_session, open_video_of, save_session
from keypose.tracker.storage.results import load_results
from keypose.tracker.storage.tracks import load_tracks, load_trajectory
from keypose.tracker.surface.fit import segment
from keypose.tracker.tracking import pool
from tests.app import surface_cases as cases
from tests.app.cli_cases import everything_in, refused
from tests.tracker import session_cases

NEAR_M = 0.03
NEAR_RAD = np.deg2rad(8)
"""The sample's voxels are 4 cm wide."""


@pytest.fixture
def session_path(tmp_path: Path) -> Path:
    return cases.write_session(tmp_path / "job")


def fit(*arguments: object) -> int:
    return main(["fit", *(str(a) for a in arguments)])


def events(capsys: pytest.CaptureFixture[str]) -> list[dict[str, Any]]:
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


def test_one_posed_mesh_is_enough_for_the_motion_of_all(session_path: Path) -> None:
    assert fit("--session", session_path) == 0
    found = load_trajectory(load_session(session_path), session_path)
    assert (found.first_frame, found.last_frame) == (0, cases.STEPS - 1)
    assert np.abs(found.ps_camera_root - cases.true_roots()).max() < NEAR_M
    off = log_rotation(transpose(cases.true_rotations()) @ found.Rs_parent_part)
    assert np.linalg.norm(off, axis=-1).max() < NEAR_RAD


def test_keyframes_stay_as_they_were_posed(tmp_path: Path) -> None:
    path = cases.write_session(tmp_path / "job", keyframes=(1, 3))
    assert fit("--session", path) == 0
    session = load_session(path)
    assert session.subject.results is not None
    spans = [(s.first_frame, s.last_frame) for s in session.subject.results.segments]
    assert spans == [(0, 1), (1, 3), (3, 4)]
    found = load_trajectory(session, path)
    for frame in (1, 3):
        np.testing.assert_allclose(found.ps_camera_root[frame], cases.true_roots()[frame])


def test_what_is_asked_for_is_kept_with_what_it_led_to(session_path: Path) -> None:
    assert fit("--session", session_path, "--weights", "contact", "--distance", "point") == 0
    session = load_session(session_path)
    assert session.view.surface is not None
    assert (session.view.surface.weights, session.view.surface.distance) == ("contact", "point")
    assert load_results(session, session_path).wanted(session) == []


def test_a_copy_leads_to_the_same_meshes_and_leaves_the_session_alone(
    session_path: Path, tmp_path: Path
) -> None:
    before = everything_in(session_path.parent)
    out = tmp_path / "elsewhere" / "try"
    assert fit("--session", session_path, "--out", out, "--binding", "smooth") == 0
    assert everything_in(session_path.parent) == before
    copy = load_session(out / "session.json")
    assert copy.view.surface is not None
    assert copy.view.surface.binding == "smooth"
    with open_video_of(copy, out / "session.json") as video:
        assert video.info.frame_count == cases.STEPS
    assert load_results(copy, out / "session.json").wanted(copy) == []


def test_tracking_such_a_session_is_fitting_it(tmp_path: Path) -> None:
    one, other = (cases.write_session(tmp_path / name) for name in ("one", "other"))
    assert fit("--session", one) == 0
    assert main(["track", str(other)]) == 0
    written = [sorted(p.name for p in at.parent.glob("tracks-*.npz")) for at in (one, other)]
    assert written[0] == written[1]
    assert len(written[0]) == 1


def test_events_have_the_form_of_those_of_tracking(
    session_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert fit("--session", session_path, "--json") == 0
    reported = events(capsys)
    assert reported[0] == {
        "event": "segment_started", "segment": 0, "of": 1, "first_frame": 0,
        "last_frame": cases.STEPS - 1,
    }  # fmt: skip
    passed = [event for event in reported if event["event"] == "pass_finished"]
    assert all(0 <= event["pass"] < event["of"] == cases.STEPS - 1 for event in passed)
    finished, summary = reported[-2:]
    assert finished["event"] == "segment_finished"
    assert finished["verdict"] == "good"
    assert summary["event"] == "finished"
    assert summary["segments_of"] == len(summary["segments"]) == 1
    assert summary["lost"] is False
    assert Path(summary["tracks"]).is_file()


def test_ctrl_c_keeps_the_steps_that_are_done(
    session_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(segment, "REPORT_S", 0.0)
    looks: list[int] = []

    def stop_at_the_third_look(work: pool._TaskQueue) -> None:
        looks.append(1)
        if len(looks) == 3:
            raise pool.Cancelled

    monkeypatch.setattr(pool._TaskQueue, "_leave_when_cancelled", stop_at_the_third_look)
    assert fit("--session", session_path) == 130
    reported = capsys.readouterr()
    assert "check frames 3–4: not fitted yet" in reported.out
    assert "Interrupted: 0 of 1 segments are finished, 1 more kept in part." in reported.err
    found = load_tracks(load_session(session_path), session_path)
    assert found.runs(tracked=False) == "3 to 4"
    assert np.abs(found.ps_camera_root - cases.true_roots())[:3].max() < NEAR_M
    out = session_path.parent / "motion"
    exported = ["export", str(session_path), "--format", "bvh,csv", "--out", str(out)]
    assert main(exported) == 0
    with (out / "frames.csv").open(encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    assert [row["pose"] for row in rows][:3] == ["keyframe", "tracked", "tracked"]
    assert "Frames: 3" in (out / "motion.bvh").read_text(encoding="utf-8")
    assert fit("--session", session_path) == 0
    assert load_session(session_path).subject.results.segments[0].missing == 0  # type: ignore[union-attr]


def test_a_mesh_that_cannot_be_used_is_left_out_and_reported(
    session_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (session_path.parent / "meshes" / "step_0002.ply").write_bytes(b"ply\nnothing more")
    unknown = load_session(session_path)
    video = unknown.view.video.model_copy(update={"fingerprint": ""})
    save_session(unknown.changed({"video": video}), session_path)
    assert fit("--session", session_path) == 0
    message = capsys.readouterr().out
    assert "frames 0–4: check frame 2" in message
    assert "step_0002.ply" in message
    tracks = load_tracks(load_session(session_path), session_path)
    assert tracks.tracked.all()
    assert np.abs(tracks.ps_camera_root - cases.true_roots()).max() < NEAR_M


def test_a_mesh_exported_again_is_fitted_and_known_from_then_on(session_path: Path) -> None:
    file = session_path.parent / "meshes" / "step_0002.ply"
    whole = file.read_bytes()
    file.write_bytes(b"")
    assert fit("--session", session_path, "--quality", "preview") in (0, 1)
    before = load_session(session_path)
    file.write_bytes(whole)
    again = ["batch", str(session_path), "--only", "outdated", "--quality", "preview"]
    assert main(again) == 0
    after = load_session(session_path)
    assert after.view.video.fingerprint != before.view.video.fingerprint
    assert before.subject.results is not None
    assert after.subject.results is not None
    assert before.subject.results.tracks != after.subject.results.tracks
    assert list(load_results(after, session_path).fitting(after)) == [(0, 4)]


def test_the_cameras_that_are_named_are_known_by_their_content(session_path: Path) -> None:
    cameras = session_path.parent / "cameras.json"
    shutil.copy(cases.SAMPLE / "cameras.json", cameras)
    chosen = ("--weights", "contact", "--quality", "preview")
    assert fit("--session", session_path, "--cameras", cameras, *chosen) in (0, 1)
    surface = load_session(session_path).view.surface
    assert surface is not None
    assert surface.cameras == "cameras.json"
    digest = hashlib.sha256(cameras.read_bytes()).hexdigest()
    assert surface.cameras_fingerprint == f"sha256:{digest}"


def test_meshes_that_were_moved_are_taken_where_they_are_named(
    session_path: Path, tmp_path: Path
) -> None:
    place = tmp_path / "far" / "away" / "scan"
    place.parent.mkdir(parents=True)
    (session_path.parent / "meshes").rename(place)
    assert fit(place, "--session", session_path) == 0
    with open_video_of(load_session(session_path), session_path) as video:
        assert video.info.path.resolve() == place.resolve()


def test_without_a_session_it_says_how_to_begin_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scan = cases.meshes(tmp_path / "scan")
    arguments = ["fit", scan, "--session", tmp_path / "session.json"]
    assert f"keypose open {scan}" in refused(capsys, tmp_path, arguments)


def test_without_a_keyframe_it_says_where_to_pose_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = cases.write_session(tmp_path / "job", keyframes=())
    message = refused(capsys, tmp_path, ["fit", "--session", path])
    assert "has no keyframe" in message
    assert f"keypose open {path}" in message


def test_a_session_about_a_video_is_for_tracking(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = session_cases.write_session(tmp_path)
    assert "is about a video" in refused(capsys, tmp_path, ["fit", "--session", path])


def test_other_meshes_than_the_sessions_are_refused(
    session_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = cases.meshes(tmp_path / "other", steps=3)
    message = refused(capsys, tmp_path, ["fit", other, "--session", session_path])
    assert "holds other meshes" in message


@pytest.mark.parametrize("option", ["--units=mm", "--up=-y"])
def test_other_units_than_those_it_was_posed_in_are_refused(
    session_path: Path, option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    message = refused(capsys, session_path.parent, ["fit", "--session", session_path, option])
    assert "was posed in meshes read" in message
    assert "change it under Fit in the page" in message


def test_cameras_that_are_none_are_refused_before_the_work(
    session_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cameras = session_path.parent / "cameras.json"
    cameras.write_text("{}", encoding="utf-8")
    arguments = ["fit", "--session", session_path, "--cameras", cameras]
    assert "cameras.json" in refused(capsys, session_path.parent, arguments)


def test_pictures_films_sheets_reports_and_exports_are_made_of_what_was_fitted(
    session_path: Path, tmp_path: Path
) -> None:
    assert fit("--session", session_path, "--quality", "preview") == 0
    out, path = tmp_path / "out", str(session_path)
    out.mkdir()
    commands = [
        ["shot", path, "--frame", "3", "--view", "all", "--out", str(out / "shot.png")],
        ["film", path, "--out", str(out / "film.mp4")],
        ["sheet", path, "--out", str(out / "sheet.png")],
        ["report", path, "--out", str(out / "report.html")],
        ["export", path, "--format", "bvh,glb,trc,csv,npz", "--out", str(out)],
        ["evaluate", path, "--reference", str(cases.SAMPLE / "truth.npz")],
    ]
    for command in commands:
        assert main(command) == 0, command
    shot = cv2.imread(str(out / "shot.png"))
    assert shot is not None
    assert shot.std() > 10
    assert (out / "report.html").stat().st_size > 10_000
    assert (out / "motion.bvh").is_file()


def test_a_model_with_holes_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = cases.write_session(tmp_path / "job", keyframes=(2,))
    file = path.parent / "meshes" / "step_0002.ply"
    mesh = trimesh.load(file, process=False)
    mesh.faces = mesh.faces[20:]
    mesh.export(file)
    reported = load_session(path)
    video = reported.view.video.model_copy(update={"fingerprint": ""})
    save_session(reported.changed({"video": video}), path)
    assert fit("--session", path) in (0, 1)
    assert capsys.readouterr().out.count("has holes") == 1


def test_times_are_the_sessions_own_where_the_meshes_are_gone(
    session_path: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert fit("--session", session_path, "--quality", "preview") == 0
    (tmp_path / "far").mkdir()
    (session_path.parent / "meshes").rename(tmp_path / "far" / "away")
    assert main(["export", str(session_path), "--format", "npz", "--out", str(tmp_path)]) == 0
    assert "missing" in capsys.readouterr().err
    times_s = np.load(tmp_path / "motion.npz")["time_s"]
    np.testing.assert_allclose(times_s, np.arange(cases.STEPS) / 25)


def test_the_tables_call_only_what_was_posed_a_keyframe(session_path: Path, tmp_path: Path) -> None:
    assert fit("--session", session_path) == 0
    out = tmp_path / "tables"
    assert main(["export", str(session_path), "--format", "csv", "--out", str(out)]) == 0
    lines = (out / "frames.csv").read_text("utf-8").splitlines()
    table = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert [row["pose"] for row in table] == ["keyframe", *["tracked"] * (cases.STEPS - 1)]


def test_info_says_what_is_wrong_with_a_mesh_that_cannot_be_used(
    session_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (session_path.parent / "meshes" / "step_0002.ply").unlink()
    assert main(["info", str(session_path.parent / "meshes")]) == 0
    assert "note         Step 2 is missing" in capsys.readouterr().out
