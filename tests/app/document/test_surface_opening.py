"""Meshes opened for the first time and again: what is guessed is told, and frames never shift."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import numpy as np
import pytest
import trimesh

from keypose.app.cli.main import main
from keypose.app.document.new import new_surface_session, open_with_reading
from keypose.app.document.open import OpenSession, copy_session, edit_state, open_for_editing
from keypose.app.render.video_frames import frame_or_grey
from keypose.tracker.body.body import preset
from keypose.tracker.body.modify import height
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.shapes import Box
from keypose.tracker.errors import KeyposeError, SessionError, SurfaceError
from keypose.tracker.storage.edit_history import Moment, base_record, edit_record
from keypose.tracker.storage.files import journal_path, load_session, open_video_of, save_session
from keypose.tracker.storage.fingerprints import setup_hash
from keypose.tracker.storage.journal import Journal
from keypose.tracker.storage.results import segment_keys
from keypose.tracker.surface.cameras.hulls import ply_bytes
from keypose.tracker.surface.mesh import SurfaceMesh
from keypose.tracker.surface.new_session import Reading
from keypose.tracker.surface.picture import SurfaceVideo
from keypose.tracker.surface.source import holds_meshes
from keypose.tracker.video import MissingFrame
from tests.app import surface_cases as cases


def place(video: Path) -> Path:
    """Where sessions live in these tests."""
    return video.parent / f"{video.stem}.keypose" / "session.json"


@pytest.fixture
def closing() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def opened(path: Path, closing: ExitStack) -> OpenSession:
    piece = open_for_editing(path, place)
    closing.callback(piece.video.close)
    return piece


def box(
    folder: Path, extents: tuple[float, float, float], count: int = 2, suffix: str = "ply"
) -> Path:
    """A box that moves on along its first axis."""
    folder.mkdir(parents=True)
    for step in range(count):
        mesh = trimesh.creation.box(extents)
        mesh.apply_translation([0.1 * step * extents[0], 0, 0])
        mesh.export(folder / f"box_{step}.{suffix}")
    return folder


def test_info_names_all_meshes_that_cannot_be_used_once_it_has_read_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = cases.meshes(tmp_path / "scan")
    files = sorted(folder.iterdir())
    files[2].unlink()
    files[4].write_bytes(files[4].read_bytes()[:-40])
    assert main(["info", str(folder)]) == 0
    assert 'note         Step 2 is missing between "' in capsys.readouterr().out
    assert main(["info", str(folder), "--check"]) == 0
    reported = capsys.readouterr().out
    assert "note         Steps 2 and 4 cannot be used. The first of them: Step 2" in reported
    assert "all can be used" not in reported
    assert main(["info", str(folder), "--check", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["missing_frames"] == [2, 4]
    assert "cut short" in facts["missing"]["4"]
    assert facts["checked"]


def test_info_says_that_all_meshes_can_be_used_only_once_it_has_read_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = cases.meshes(tmp_path / "scan")
    for more, told in (([], False), (["--check"], True)):
        assert main(["info", str(folder), *more]) == 0
        words = "every mesh was read, and all can be used"
        assert (words in capsys.readouterr().out) == told


def test_a_folder_of_meshes_begins_a_session_whose_camera_sees_them(
    tmp_path: Path, closing: ExitStack
) -> None:
    piece = opened(cases.meshes(tmp_path / "scan"), closing)
    assert piece.fresh
    assert isinstance(piece.video, SurfaceVideo)
    session = piece.session
    assert session.view.video.frame_count == piece.video.info.frame_count == cases.STEPS
    assert session.view.video.fingerprint == piece.video.fingerprint()
    for frame in range(cases.STEPS):
        uv = session.view.camera.project(piece.video.steps.shape(frame).vertices)
        assert (uv > 0).all()
        assert (uv < (session.view.camera.width, session.view.camera.height)).all()


def test_what_files_do_not_show_is_guessed_and_reported(tmp_path: Path, closing: ExitStack) -> None:
    piece = opened(box(tmp_path / "scan", (400.0, 300.0, 1750.0)), closing)
    assert piece.session.view.surface is not None
    assert (piece.session.view.surface.units, piece.session.view.surface.up) == ("mm", "+z")
    (words,) = piece.news
    assert "read in mm, 1.75 m large" in words
    assert "+z up" in words
    low, high = (f(piece.video.steps.shape(0).vertices, axis=0) for f in (np.min, np.max))  # type: ignore[attr-defined]
    np.testing.assert_allclose(high - low, (0.4, 1.75, 0.3), atol=1e-6)


def test_what_files_give_is_not_guessed(tmp_path: Path, closing: ExitStack) -> None:
    piece = opened(box(tmp_path / "scan", (40.0, 175.0, 30.0), suffix="glb"), closing)
    assert piece.session.view.surface is not None
    assert (piece.session.view.surface.units, piece.session.view.surface.up) == ("m", "+y")
    assert piece.news == ()


def test_the_body_first_stands_in_the_first_mesh(tmp_path: Path, closing: ExitStack) -> None:
    piece = opened(box(tmp_path / "scan", (0.5, 1.8, 0.4)), closing)
    edit, problem = edit_state(piece)
    assert problem == ""
    joints = pose_transforms(edit.skeleton, edit.opening)[:, :3, 3]
    assert isinstance(piece.video, SurfaceVideo)
    vertices = piece.video.steps.shape(0).vertices
    assert (joints[:, 1] > vertices[:, 1].min()).all()
    assert (joints[:, 1] < vertices[:, 1].max()).all()
    middle = (vertices.min(axis=0) + vertices.max(axis=0)) / 2
    assert np.abs(edit.opening.p_camera_root - middle).max() < 0.3


def test_meshes_that_wander_far_off_are_seen_well_where_they_begin(
    tmp_path: Path, closing: ExitStack
) -> None:
    folder = box(tmp_path / "scan", (0.5, 1.7, 0.4), count=1)
    mesh = trimesh.creation.box((0.5, 1.7, 0.4))
    mesh.apply_translation([60.0, 0, 0])
    mesh.export(folder / "box_1.ply")
    piece = opened(folder, closing)
    assert isinstance(piece.video, SurfaceVideo)
    uv = piece.session.view.camera.project(piece.video.steps.shape(0).vertices)
    assert np.ptp(uv[:, 1]) > 0.3 * piece.session.view.camera.height
    assert ((uv > 0) & (uv < (960, 720))).all()


def test_the_session_is_found_by_its_meshes_once_it_is_there(
    tmp_path: Path, closing: ExitStack
) -> None:
    scan = cases.meshes(tmp_path / "scan")
    fresh = opened(scan, closing)
    fresh.session_path.parent.mkdir()
    save_session(fresh.session, fresh.session_path)
    again = opened(scan, closing)
    assert not again.fresh
    assert again.session == fresh.session


def test_meshes_that_were_renamed_are_found_again(tmp_path: Path, closing: ExitStack) -> None:
    path = cases.write_session(tmp_path / "job")
    (path.parent / "meshes").rename(path.parent / "take two")
    piece = opened(path, closing)
    assert piece.session.view.video.path == "take two"
    assert any("found again" in words for words in piece.news)


def test_a_mesh_may_be_exported_again_as_it_is_asked_for(
    tmp_path: Path, closing: ExitStack
) -> None:
    path = cases.write_session(tmp_path / "job")
    file = path.parent / "meshes" / "step_0001.ply"
    whole = file.read_bytes()
    file.write_bytes(b"")
    broken = opened(path, closing)
    with pytest.raises(MissingFrame, match="export it again"):
        broken.video.frame(1)
    save_session(broken.session, path)
    file.write_bytes(whole)
    piece = opened(path, closing)
    assert piece.news == ("The meshes have changed since they were last opened: fit again.",)
    piece.video.frame(1)
    assert piece.session.view.video.fingerprint == piece.video.fingerprint()
    assert segment_keys(piece.session) != segment_keys(broken.session)
    save_session(piece.session, path)
    assert opened(path, closing).news == ()


def test_meshes_exported_again_leave_the_history_as_it_was(
    tmp_path: Path, closing: ExitStack
) -> None:
    path = cases.write_session(tmp_path / "job")
    before, after = load_session(path), cases.session(keyframes=(0, 2))
    after = before.changed({"keyframes": after.subject.keyframes})
    last = Moment(before)
    edited = Moment(after, last.history.after(before, "keyframe set", 0), 2)
    journal = Journal(journal_path(path), 0)
    journal.begin_anew([base_record(last), edit_record(last, edited)])
    file = path.parent / "meshes" / "step_0001.ply"
    file.write_bytes(file.read_bytes() + b"\n")
    piece = opened(path, closing)
    assert [k.frame for k in piece.session.subject.keyframes] == [0, 2]
    assert piece.journal.follows
    assert [step.label for step in piece.history.past] == ["keyframe set"]
    now = piece.session.view.video.fingerprint
    assert now != before.view.video.fingerprint
    assert piece.history.past[0].doc.view.video.fingerprint == now


def test_as_many_meshes_as_there_were_are_wanted(tmp_path: Path) -> None:
    path = cases.write_session(tmp_path / "job")
    (path.parent / "meshes" / "step_0004.ply").unlink()
    with pytest.raises(SessionError, match="it has 4 frames instead of 5"):
        open_video_of(load_session(path), path)


def test_cameras_calibrated_again_are_reported_too(tmp_path: Path, closing: ExitStack) -> None:
    scan, rig = cases.meshes(tmp_path / "scan"), tmp_path / "cameras.json"
    shutil.copy(cases.SAMPLE / "cameras.json", rig)
    path, _ = open_with_reading(scan, place, Reading(), rig)
    before = opened(path, closing)
    assert before.news == ()
    rig.write_text(rig.read_text(encoding="utf-8") + "\n", encoding="utf-8")
    piece = opened(path, closing)
    assert piece.news == ("The cameras have changed since they were last opened: fit again.",)
    posed = {"keyframes": cases.session().subject.keyframes, "body": cases.session().subject.body}
    now, then = (p.session.changed(posed) for p in (piece, before))
    assert segment_keys(now) != segment_keys(then)
    assert setup_hash(now) != setup_hash(then)


def test_a_film_of_images_with_a_mesh_among_them_stays_a_film(tmp_path: Path) -> None:
    folder = tmp_path / "film"
    folder.mkdir()
    for number in range(20):
        (folder / f"{number:03}.png").touch()
    (folder / "prop.obj").touch()
    assert not holds_meshes(folder)


def test_meshes_with_their_textures_beside_them_are_meshes(tmp_path: Path) -> None:
    folder = tmp_path / "scan"
    folder.mkdir()
    for number in range(5):
        for suffix in ("obj", "mtl", "png"):
            (folder / f"{number:03}.{suffix}").touch()
    assert holds_meshes(folder)


def test_meshes_are_read_as_a_person_says_until_a_body_is_posed_in_them(tmp_path: Path) -> None:
    scan = cases.meshes(tmp_path / "scan")
    path, news = open_with_reading(scan, place, Reading("cm", "+z"), None)
    assert news == ()
    surface = load_session(path).view.surface
    assert surface is not None
    assert (surface.units, surface.up) == ("cm", "+z")
    again, news = open_with_reading(scan, place, Reading("in"), None)
    assert (again, news) == (path, ())
    changed = load_session(path).view.surface
    assert changed is not None
    assert (changed.units, changed.up) == ("in", "+z")
    posed = cases.write_session(tmp_path / "job")
    before = posed.read_bytes()
    with pytest.raises(SessionError, match="has poses already"):
        open_with_reading(posed, place, Reading("mm"), None)
    assert posed.read_bytes() == before


def test_cameras_give_units_and_what_is_up(tmp_path: Path, closing: ExitStack) -> None:
    scan, rig = cases.meshes(tmp_path / "scan"), tmp_path / "cameras.json"
    shutil.copy(cases.SAMPLE / "cameras.json", rig)
    path, news = open_with_reading(scan, place, Reading(), rig)
    assert news == ()
    surface = load_session(path).view.surface
    assert surface is not None
    assert (surface.units, surface.up, surface.cameras) == ("cm", "+z", "../cameras.json")
    assert opened(path, closing).video.info.frame_count == cases.STEPS


def test_what_was_said_before_stays_when_something_else_is_said(tmp_path: Path) -> None:
    scan, rig = cases.meshes(tmp_path / "scan"), tmp_path / "cameras.json"
    shutil.copy(cases.SAMPLE / "cameras.json", rig)
    path, _ = open_with_reading(scan, place, Reading("mm"), rig)
    before = load_session(path)
    assert before.view.surface is not None
    chosen = before.view.surface.model_copy(update={"fps": 50.0, "weights": "contact"})
    save_session(before.changed({"surface": chosen}), path)
    open_with_reading(scan, place, Reading(up="-y"), None)
    surface = load_session(path).view.surface
    assert surface is not None
    assert (surface.units, surface.up, surface.fps) == ("mm", "-y", 50.0)
    assert (surface.weights, surface.cameras) == ("contact", "../cameras.json")
    assert surface.cameras_fingerprint == chosen.cameras_fingerprint != ""
    assert surface.p_camera_surface != chosen.p_camera_surface


def test_a_copy_of_a_session_leads_to_its_meshes(tmp_path: Path, closing: ExitStack) -> None:
    path = cases.write_session(tmp_path / "job", cameras="cameras.json")
    copy = copy_session(path, tmp_path / "somewhere" / "else")
    surface = load_session(copy).view.surface
    assert surface is not None
    assert surface.cameras == "../../job/cameras.json"
    assert opened(copy, closing).video.info.frame_count == cases.STEPS


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 a zip"])
def test_meshes_of_which_none_can_be_used_are_refused_in_a_sentence(
    tmp_path: Path, content: bytes
) -> None:
    folder = tmp_path / "scan"
    folder.mkdir()
    for number in range(3):
        (folder / f"{number}.ply").write_bytes(content)
    with pytest.raises(KeyposeError, match=r'^Step 0 \("0.ply"\) .*\.$'):
        open_for_editing(folder, place)


def test_a_mesh_that_is_missing_is_a_frame_that_says_so(tmp_path: Path, closing: ExitStack) -> None:
    scan = cases.meshes(tmp_path / "scan")
    (scan / "step_0002.ply").unlink()
    piece = opened(scan, closing)
    assert piece.video.info.missing == (2,)
    with pytest.raises(MissingFrame, match="Step 2 is missing"):
        piece.video.frame(2)
    grey = frame_or_grey(piece.video, 2)
    assert (grey == 96).mean() > 0.5
    assert (grey > 200).any()


def test_the_facts_of_meshes_are_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    scan = box(tmp_path / "scan", (0.5, 1.8, 0.4), count=3)
    assert main(["info", str(scan), "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert (facts["frame_count"], facts["vertices"], facts["faces"]) == (3, 8, 12)
    assert facts["units"] is None
    assert main(["info", str(scan)]) == 0
    assert "0.5 × 1.8 × 0.4 units" in capsys.readouterr().out


def test_a_new_body_is_as_tall_as_the_person_that_is_observed(tmp_path: Path) -> None:
    box = Box(low_m=(-0.2, 0.0, -0.1), high_m=(0.2, 1.5, 0.1)).mesh()
    (tmp_path / "meshes").mkdir()
    mesh = SurfaceMesh(box.vertices, box.faces)
    (tmp_path / "meshes" / "step_0.ply").write_bytes(ply_bytes(mesh))
    session, _ = new_surface_session(
        tmp_path / "meshes", tmp_path / "session.json", Reading(units="m", up="+y")
    )
    assert height(session.subject.body) == pytest.approx(1.5)
    tiny, _ = new_surface_session(
        tmp_path / "meshes", tmp_path / "session.json", Reading(units="mm", up="+y")
    )
    assert height(tiny.subject.body) == height(preset("adult_male"))


def test_meshes_far_from_their_origin_are_refused_in_a_sentence(tmp_path: Path) -> None:
    box = Box(low_m=(-0.2, 0.0, -0.1), high_m=(0.2, 1.5, 0.1)).mesh()
    (tmp_path / "meshes").mkdir()
    mesh = SurfaceMesh(box.vertices + np.array([3e5, 0.0, 0.0]), box.faces)
    (tmp_path / "meshes" / "step_0.ply").write_bytes(ply_bytes(mesh))
    with pytest.raises(SurfaceError, match="300 km from their origin"):
        new_surface_session(
            tmp_path / "meshes", tmp_path / "session.json", Reading(units="m", up="+y")
        )
