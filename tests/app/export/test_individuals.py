"""Individuals of a file become the bodies of a session, each its own."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.app.export.individuals import assigned
from keypose.app.export.motion_files import files_of_bodies
from keypose.app.orders.motion import MotionOrder
from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.formats.keypoint_files import read_people
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.keypoints import JOINTS
from keypose.tracker.keypoints.on_body import points_on_body
from keypose.tracker.session import Keyframe, Session
from keypose.tracker.session.bodies import TrackedBody
from keypose.tracker.storage.files import load_session, save_session
from keypose.tracker.storage.sidecars import load_first_motion
from tests.app.export.test_several_bodies import ASIDE_M as BESIDE_M
from tests.app.export.test_several_bodies import bodies as recorded_bodies
from tests.tracker.formats import animals, recordings

SESSION = recordings.session("person")
BODY = SESSION.subject.body
CRATE = preset("box")
ASIDE_M = {"ann": -0.6, "bob": 0.7}
FRAMES = 3


def seen(aside_m: float) -> Array:
    """(N, 12, 2) pixels at which the joints of the sample's person are seen, moved aside."""
    _, parts, points = points_on_body(BODY, JOINTS)
    motion, skeleton = recordings.trajectory("person"), Skeleton.of(BODY)
    Ts = [pose_transforms(skeleton, motion.pose(frame))[parts] for frame in range(FRAMES)]
    ps = [np.einsum("jab,jb->ja", T[:, :3, :3], points) + T[:, :3, 3] for T in Ts]
    return SESSION.view.camera.project(np.array(ps) + np.array([aside_m, 0.0, 0.0]))


UV = np.array([seen(aside) for aside in ASIDE_M.values()])


def people_with(key: str) -> Callable[[Path, tuple[str, ...]], Path]:
    """A file of COCO whose people say by this key who they are; the second first in each frame."""

    def write(folder: Path, names: tuple[str, ...]) -> Path:
        annotations = [
            {
                "image_id": frame,
                "keypoints": np.c_[uv[frame], np.ones(len(JOINTS))].ravel().tolist(),
                key: name,
            }
            for frame in range(FRAMES)
            for name, uv in reversed(list(zip(names, UV, strict=True)))
        ]
        categories = [{"keypoints": list(JOINTS)}]
        file = folder / "people.json"
        file.write_text(json.dumps({"annotations": annotations, "categories": categories}))
        return file

    return write


def dlc(folder: Path, names: tuple[str, ...]) -> Path:
    columns = animals.dlc_columns(JOINTS, names)
    return animals.dlc_csv(folder / "dlc.csv", columns, animals.dlc_values(UV))


KINDS: dict[str, Callable[[Path, tuple[str, ...]], Path]] = {
    "SLEAP": lambda folder, names: animals.sleap_h5(folder / "a.h5", JOINTS, UV, tracks=names),
    "SLEAP, CSV": lambda folder, names: animals.sleap_csv(folder / "a.csv", JOINTS, UV, names),
    "DeepLabCut": dlc,
    "COCO": people_with("track_id"),
    "AlphaPose": people_with("idx"),
}


def session_of(*bodies: TrackedBody) -> Session:
    bare = SESSION.changed({"keyframes": (), "results": None})
    return bare.model_copy(update={"bodies": bodies})


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Ann, a crate, and Bob, none of them posed."""
    shutil.copy(recordings.SAMPLES / "person" / "person.mp4", tmp_path)
    ann, bob = (TrackedBody(id=name, body=BODY) for name in ASIDE_M)
    crate = TrackedBody(id="crate", body=CRATE)
    save_session(session_of(ann, crate, bob), tmp_path / "session.json")
    return tmp_path / "session.json"


def imported(path: Path, file: Path, *words: str) -> int:
    asked = [] if "--world" in words or file.suffix == ".trc" else ["--keypoints", "--every", "2"]
    return main(["import", str(path), str(file), *asked, *words])


def aside(path: Path, name: str) -> float:
    """How far aside the first draft of a body lies, metres of the truth's distance."""
    draft = load_session(path).about(name).subject.drafts[0]
    truth = recordings.trajectory("person").ps_camera_root[0]
    x, _, z = draft.root_m
    return float(x / z * truth[2] - truth[0])


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        *((kind, ("Ann", "BOB")) for kind in KINDS),
        *((kind, ("1", "2")) for kind in ("SLEAP", "COCO")),
    ],
)
def test_individuals_become_the_bodies_of_their_names_or_those_that_are_left_in_order(
    kind: str, names: tuple[str, str], path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = KINDS[kind](path.parent, names)
    assert imported(path, file) == 0
    notes = capsys.readouterr().err
    order = "" if names[0] == "Ann" else " by their order"
    first, second = names
    if order and kind in ("COCO", "AlphaPose"):
        first, second = second, first  # in each frame the second is listed first
    assert f"{file.name}: {first} → ann{order}, {second} → bob{order}." in notes
    assert f"Nothing in {file.name} for crate." in notes
    assert "--body bob --from drafts --every 1 makes keyframes" in notes
    drafts = {body.id: [k.frame for k in body.drafts] for body in load_session(path).bodies}
    assert drafts == {"ann": [0, 2], "crate": [], "bob": [0, 2]}
    where = dict(zip(names, ASIDE_M.values(), strict=True))
    assert aside(path, "ann") == pytest.approx(where[first], abs=0.15)
    assert aside(path, "bob") == pytest.approx(where[second], abs=0.15)


def test_json_has_what_each_body_took_over(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert imported(path, dlc(path.parent, ("ann", "bob")), "--json") == 0
    facts = json.loads(capsys.readouterr().out)["bodies"]
    assert {name: len(each["drafts"]) for name, each in facts.items()} == {"ann": 2, "bob": 2}


def test_one_individual_goes_to_the_body_that_is_asked_for(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = dlc(path.parent, ("mouse1", "mouse2"))
    assert imported(path, file, "--individual", "mouse1", "--body", "bob") == 0
    assert aside(path, "bob") == pytest.approx(ASIDE_M["ann"], abs=0.15)
    assert load_session(path).about("ann").subject.drafts == ()
    assert imported(path, file, "--body", "ann") == 2
    assert "2 individuals, mouse1 and mouse2. Choose with --individual" in capsys.readouterr().err
    named = dlc(path.parent, ("bob", "ann"))
    assert imported(path, named, "--body", "ann") == 0
    assert aside(path, "ann") == pytest.approx(ASIDE_M["bob"], abs=0.15)


def test_an_individual_that_is_asked_for_goes_to_the_body_of_its_name(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = dlc(path.parent, ("ann", "bob"))
    assert imported(path, file, "--individual", "bob") == 0
    assert "bob → bob" in capsys.readouterr().err
    assert aside(path, "bob") == pytest.approx(ASIDE_M["bob"], abs=0.15)


def test_people_whom_a_file_does_not_tell_apart_are_refused_for_several_bodies(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = path.read_bytes()
    file = people_with("nothing")(path.parent, ("1", "2"))
    assert imported(path, file) == 2
    assert "up to 2 people in a frame and does not tell them apart" in capsys.readouterr().err
    assert path.read_bytes() == before
    assert imported(path, file, "--body", "bob") == 0
    assert imported(path, file, "--individual", "1") == 2
    assert "does not tell individuals apart" in capsys.readouterr().err


def test_a_file_of_no_body_of_the_session_changes_nothing(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    before = path.read_bytes()
    columns = animals.dlc_columns([f"spot{n}" for n in range(len(JOINTS))], ("a", "b"))
    file = animals.dlc_csv(path.parent / "dlc.csv", columns, animals.dlc_values(UV))
    assert imported(path, file) == 2
    assert capsys.readouterr().err.startswith("ann: dlc.csv names 0 places")
    assert path.read_bytes() == before


def test_a_session_of_one_body_is_asked_which_individual_is_meant(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save_session(session_of(TrackedBody(body=BODY)), path)
    file = dlc(path.parent, ("ann", "bob"))
    assert imported(path, file) == 2
    assert "2 individuals, ann and bob. Choose with --individual" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("ids", "individuals"),
    [
        ([7, 4], ("4", "7")),
        ([[0.0], [1.0]], ()),
        ([[3], [1]], ("1", "3")),
        ([-1, -1], ()),
        ([5, 5], ()),
        ([5, None], ()),
        (["a", "b"], ("b", "a")),
        ([True, False], ()),
    ],
)
def test_people_are_told_apart_only_by_identities_that_all_have_and_no_frame_has_twice(
    ids: list[Any], individuals: tuple[str, ...], tmp_path: Path
) -> None:
    people = read_people(people_with("track_id")(tmp_path, tuple(ids)))
    assert people.individuals == individuals


@pytest.mark.parametrize("kind", ["OpenPose", "MMPose"])
def test_people_of_openpose_and_mmpose_are_told_apart(kind: str, tmp_path: Path) -> None:
    flat = [0.5] * 51
    if kind == "OpenPose":
        people = [{"person_id": [n], "pose_keypoints_2d": flat} for n in (2, 1)]
        (tmp_path / "a_000000_keypoints.json").write_text(json.dumps({"people": people}))
        read = read_people(tmp_path)
    else:
        places = np.reshape(flat[:34], (17, 2)).tolist()
        instances = [{"track_id": n, "keypoints": places} for n in (2, 1)]
        listed = {"instance_info": [{"frame_id": 1, "instances": instances}]}
        (tmp_path / "a.json").write_text(json.dumps(listed))
        read = read_people(tmp_path / "a.json")
    assert read.individuals == ("2", "1")
    assert read.of_individual("a", "1").most_at_once == 1


def test_a_motion_of_all_bodies_comes_back_to_each_by_its_name(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files, _ = files_of_bodies("trc", recorded_bodies(), MotionOrder(together=True))
    file = path.parent / "motion.trc"
    file.write_bytes(files["motion.trc"])
    assert imported(path, file) == 0
    said = capsys.readouterr()
    assert "motion.trc: ann → ann, crate → crate, bob → bob." in said.err
    assert "crate: motion.trc has 1 joints" in said.err  # which do not say how it is turned
    heads = [line for line in said.out.splitlines() if line.endswith("):")]
    assert [head.split()[0] for head in heads] == ["ann", "bob"]
    session = load_session(path)
    ann, bob = (load_first_motion(session.about(name), path.parent) for name in ASIDE_M)
    assert ann is not None
    assert bob is not None
    assert (ann.first_frame, ann.last_frame) == (0, 72)
    assert (bob.first_frame, bob.last_frame) == (10, 50)
    assert "it lies beside ann as in the file" in said.out
    apart = bob.ps_camera_root - ann.ps_camera_root[10:51]
    expected = np.linalg.norm(BESIDE_M)
    np.testing.assert_allclose(np.linalg.norm(apart, axis=1), expected, atol=1e-3)


def test_a_body_with_keyframes_says_where_the_files_world_lies(path: Path) -> None:
    session, motion = load_session(path), recordings.trajectory("person")
    moved = motion.ps_camera_root + np.array(BESIDE_M)
    poses = [Pose(motion.Rs_parent_part[frame], moved[frame]) for frame in (20, 40)]
    keyframes = tuple(
        Keyframe.of(Skeleton.of(BODY), pose, frame, frame / 30)
        for pose, frame in zip(poses, (20, 40), strict=True)
    )
    bob = session.about("bob").subject.model_copy(update={"keyframes": keyframes})
    save_session(session.with_body(bob), path)
    files, _ = files_of_bodies("trc", recorded_bodies(), MotionOrder(together=True))
    file = path.parent / "motion.trc"
    file.write_bytes(files["motion.trc"])
    assert imported(path, file) == 0
    ann = load_first_motion(load_session(path).about("ann"), path.parent)
    assert ann is not None
    np.testing.assert_allclose(ann.ps_camera_root, motion.ps_camera_root, atol=2e-3)


def test_more_individuals_than_bodies_are_left_out_and_fewer_leave_bodies() -> None:
    one, two, box = (TrackedBody(id=n, body=b) for n, b in (("a", BODY), ("b", BODY), ("c", CRATE)))
    more = assigned(("x", "B", "y", "z"), (one, two, box), lambda body: body is not box)
    assert more.individual_of == {"a": "x", "b": "B"}
    assert more.by_order == ("a",)
    assert (more.left_out, more.without) == (("y", "z"), ("c",))
    assert more.sentences("f.h5") == [
        "f.h5: x → a by their order, B → b.",
        "y and z are no body of the session: left out.",
        "Nothing in f.h5 for c.",
    ]
    assert assigned(("box",), (one, two, box), lambda _: False).individual_of == {"c": "box"}
