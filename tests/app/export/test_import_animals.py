"""Keypoints of an animal, under its owner's names, become drafts of an animal's body."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.geometry.rotations import Array, exp_rotation
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.storage.files import load_session, save_session
from tests.app.cli_cases import refused
from tests.tracker.formats import animals, recordings

DOG = preset("dog")
SKELETON = Skeleton.of(DOG)
CAMERA = recordings.session("person").view.camera
PLACES = {
    "Nose": ("head", "nose"), "L_front_paw": ("left_front_lower_leg", "left_front_paw"),
    "paw_fore_R": ("right_front_lower_leg", "right_front_paw"),
    "hindPawL": ("left_hind_lower_leg", "left_hind_paw"),
    "RightBackPaw": ("right_hind_lower_leg", "right_hind_paw"),
    "tailBase": ("tail", ""), "tip": ("tail", "tail_tip"), "withers": ("neck", ""),
    "throat": ("head", ""),
}  # fmt: skip
"""What a file calls places of the dog; the last four names say nothing to anybody else."""
MAP = ("tailBase=tail", "tip=tail.end", "withers=neck", "throat=head")


def _seen() -> Array:
    """(1, 3, L, 2) pixels in three frames of a dog that turns."""
    parts = DOG.parts
    places = tuple(
        ((DOG.index(p), parts[DOG.index(p)].landmarks.get(landmark, (0.0, 0.0, 0.0))),)
        for p, landmark in PLACES.values()
    )
    points = BodyPoints(SKELETON, places)
    rows = []
    for n in range(3):
        pose = Pose.rest(SKELETON, (0.1, 0.0, 3.0))
        Rs = pose.Rs_parent_part.copy()
        Rs[0] = exp_rotation((0.0, np.pi / 2 + 0.15 * n, 0.0))
        ps = points.at(pose_transforms(SKELETON, Pose(Rs, pose.p_camera_root)))
        rows.append(CAMERA.project(ps))
    return np.array([rows])


UV = _seen()


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A session of a dog without keyframes, beside a film."""
    shutil.copy(recordings.SAMPLES / "person" / "person.mp4", tmp_path)
    session = recordings.session("person").changed({"keyframes": (), "body": DOG})
    save_session(session, tmp_path / "session.json")
    return tmp_path / "session.json"


def _keypoints(folder: Path, kind: str) -> Path:
    if kind == "SLEAP":
        return animals.sleap_h5(folder / "dog.h5", tuple(PLACES), UV)
    columns = animals.dlc_columns(tuple(PLACES))
    return animals.dlc_table_h5(folder / "dog.h5", columns, animals.dlc_values(UV))


@pytest.mark.parametrize("kind", ["SLEAP", "DeepLabCut"])
def test_a_dogs_keypoints_become_drafts_seen_where_they_are(
    path: Path, capsys: pytest.CaptureFixture[str], kind: str
) -> None:
    file = _keypoints(path.parent, kind)
    message = [word for pair in MAP for word in ("--map", pair)]
    command = ["import", str(path), str(file), "--keypoints", "--every", "2", "--json", *message]
    assert main(command) == 0
    reported = json.loads(capsys.readouterr().out)
    assert [draft["frame"] for draft in reported["drafts"]] == [0, 2]
    assert all(draft["miss_px"] < 2.0 for draft in reported["drafts"])
    assert reported["matched"]["tip"] == "tail.end"
    assert not reported["left_out"]
    assert len(load_session(path).subject.drafts) == 2


def test_what_matched_and_what_did_not_is_listed(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = _keypoints(path.parent, "SLEAP")
    assert main(["import", str(path), str(file), "--keypoints", "--frames", "0"]) == 0
    reported = capsys.readouterr().out
    assert "Matched 5 keypoints (the body's own): nose = nose, " in reported
    assert "l_front_paw = left_front_paw, paw_fore_r = right_front_paw, " in reported
    assert "Left out 4: tail_base, tip, withers, throat" in reported


@pytest.mark.parametrize(
    ("message", "words"),
    [
        ("wing=tail", "dog.h5 has no keypoint 'wing'; it has nose, "),
        ("tip=wing", "The body has no place 'wing': say PART, PART.end or a landmark"),
        ("tip=tail.feather", "The body has no place 'tail.feather'"),
        ("tip", "'tip' is not NAME=PLACE"),
    ],
)
def test_a_map_that_leads_nowhere_leaves_the_session_as_it_was(
    path: Path, capsys: pytest.CaptureFixture[str], message: str, words: str
) -> None:
    file = _keypoints(path.parent, "SLEAP")
    command = ["import", path, file, "--keypoints", "--map", message]
    assert words in refused(capsys, path.parent, command)
