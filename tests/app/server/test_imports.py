"""Imports of a real server: a file is recognised, imported as a step that can be undone, or refused
in a sentence that loses nothing."""

from __future__ import annotations

import json
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.error import HTTPError
from urllib.parse import quote
from urllib.request import ProxyHandler, Request, build_opener

import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.formats.joint_names import matched
from keypose.tracker.keypoints.layouts import LAYOUTS
from keypose.tracker.solver.posed import BodyPoints
from keypose.tracker.storage.files import load_session
from tests.app.serving import LONGEST_S, ROOT, Keypose, Visitor
from tests.tracker.formats import recordings

TRUTH = recordings.trajectory("person")
SESSION = recordings.session("person")
BVH = recordings.bvh_of(Skeleton.of(SESSION.subject.body), TRUTH, 1 / 30).encode()
PARTS = ("nose", "left_shoulder", "right_shoulder", "left_hip", "right_hip")


class Desk:
    """A server with the person open, another visitor who sees what becomes of it, and its HTTP."""

    def __init__(self, folder: Path) -> None:
        place = folder / "person"
        place.mkdir()
        for name in ("person.mp4", "session.json"):
            shutil.copy(ROOT / "sample_videos" / "person" / name, place)
        self.session = place / "session.json"
        self.keypose = Keypose(str(self.session), "--workspace", str(folder / "workspace"))
        self.visitor = Visitor(self.keypose)

    def ask(self, path: str, method: str = "GET", body: bytes | None = None) -> tuple[int, Any]:
        headers = {**self.keypose.entered.headers, "Origin": self.keypose.origin}
        request = Request(self.keypose.origin + path, body, headers, method=method)
        try:
            with build_opener(ProxyHandler({})).open(request, timeout=LONGEST_S) as answer:
                return answer.status, json.loads(answer.read())
        except HTTPError as error:
            with error:
                return error.code, json.loads(error.read())

    def until_over(self, id: str) -> dict[str, Any]:
        end = time.monotonic() + LONGEST_S
        while (state := self.ask(f"/imports/{id}")[1])["state"] == "running":
            assert time.monotonic() < end, state
            time.sleep(0.05)
        return dict(state)

    def recognised(self, name: str, content: bytes) -> tuple[str, dict[str, Any]]:
        status, answer = self.ask(f"/imports?name={name}", "POST", content)
        assert status == 200, answer
        return answer["id"], self.until_over(answer["id"])

    def imported(self, id: str, kind: str, **choices: Any) -> dict[str, Any]:
        order = json.dumps({"kind": kind, **choices}).encode()
        status, answer = self.ask(f"/imports/{id}", "POST", order)
        assert status == 200, answer
        return self.until_over(id)

    def undo(self) -> None:
        self.visitor.do(do="undo")


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    made = Desk(tmp_path_factory.mktemp("imports"))
    yield made
    made.visitor.leave()
    code, words = made.keypose.end()
    assert code == 0, words
    assert "Traceback" not in words, words


def coco(frames: list[int]) -> bytes:
    """COCO's list of what a perfect detector sees of the true motion at these frames."""
    skeleton, names = Skeleton.of(SESSION.subject.body), LAYOUTS["COCO_17"]
    known = matched(skeleton, names, "a.json")
    points = BodyPoints(skeleton, tuple(known.places))
    annotations = []
    for frame in frames:
        table = np.zeros((len(names), 3))
        ps = points.at(pose_transforms(skeleton, TRUTH.pose(frame)))
        table[known.indices, :2], table[known.indices, 2] = SESSION.view.camera.project(ps), 1.0
        annotations.append({"image_id": frame, "keypoints": table.ravel().tolist()})
    return json.dumps(annotations).encode()


def sleap(*names: str) -> bytes:
    """SLEAP's table of several animals."""
    rows = [
        "track,frame_idx,instance.score,"
        + ",".join(f"{p}.{c}" for p in PARTS for c in ("x", "y", "score"))
    ]
    places = ["320,60,1", "300,90,1", "340,90,1", "305,160,1", "335,160,1"]
    rows += [",".join([name, "0", "1", *places]) for name in names]
    return "\n".join(rows).encode()


def test_a_motion_is_recognised_and_becomes_the_first_motion_that_the_command_line_makes(
    desk: Desk, tmp_path: Path
) -> None:
    id, state = desk.recognised("walk.bvh", BVH)
    found = state["found"]
    assert (found["kind"], found["program"]) == ("motion", "BVH")
    assert found["facts"]["frames"] == len(TRUTH)
    assert found["facts"]["fps"] == pytest.approx(30, rel=1e-3)
    feet = {"kind": "motion", "unit": "feet"}
    for order in (feet, {"kind": "nothing"}, {"kind": "motion", "out": "/etc"}):
        assert desk.ask(f"/imports/{id}", "POST", json.dumps(order).encode())[0] == 400
    state = desk.imported(id, "motion")
    assert state["state"] == "done", state
    assert state["words"] == f"walk.bvh imported, frames 0–{len(TRUTH) - 1}."
    assert "Joint error 0.0 cm (rms). Aligned with keyframes 0, 24" in state["detail"]
    desk.visitor.until(lambda: desk.visitor.seen["undo"]["undo"] == "import")
    assert desk.ask(f"/imports/{id}", "DELETE")[0] == 200
    assert desk.ask(f"/imports/{id}")[0] == 404
    (written,) = (path.name for path in desk.session.parent.glob("first-*.npz"))
    place = tmp_path / "person"
    place.mkdir()
    for name in ("person.mp4", "session.json"):
        shutil.copy(ROOT / "sample_videos" / "person" / name, place)
    (tmp_path / "walk.bvh").write_bytes(BVH)
    assert main(["import", str(place / "session.json"), str(tmp_path / "walk.bvh")]) == 0
    reference = load_session(place / "session.json").subject.first_motion
    assert reference is not None
    assert reference.file == written  # its name is a digest of what it holds
    desk.undo()


def test_keypoints_become_drafts_beside_the_keyframes(desk: Desk) -> None:
    before = desk.visitor.seen["keys"]["frames"]
    id, state = desk.recognised("detected.json", coco([10, 24, 36]))
    assert (state["found"]["kind"], state["found"]["program"]) == ("keypoints", "COCO")
    assert state["found"]["facts"]["people"] == 1
    state = desk.imported(id, "keypoints", frames="10,24,36")
    assert state["words"] == "2 drafts made from detected.json: frames 10 and 36."
    assert desk.visitor.seen["keys"]["frames"] == before
    again = desk.imported(id, "keypoints", frames="10,24")
    assert again["state"] == "failed"
    assert again["words"] == "All of these frames are posed already: choose others."
    desk.undo()


def test_a_camera_is_shown_before_it_is_taken_over(desk: Desk) -> None:
    id, state = desk.recognised("shot.chan", b"1 0 1.5 0 -10 0 0 30")
    assert state["found"]["kind"] == "camera"
    assert state["found"]["facts"]["turned_deg"] > 1
    assert desk.imported(id, "camera")["words"].startswith("Camera of shot.chan imported:")
    desk.undo()


def test_a_camera_beside_the_film_is_placed_by_its_start_frame_and_what_is_odd_is_told(
    desk: Desk,
) -> None:
    lines = (f"{1001 + k} 0 1.5 0 -10 {k} 0 30" for k in range(20))
    id, state = desk.recognised("plate.chan", "\n".join(lines).encode())
    facts = state["found"]["facts"]
    assert facts["columns"] is True
    assert "say which frame of the film" in facts["notes"][0]
    assert desk.imported(id, "camera")["state"] == "failed"
    done = desk.imported(id, "camera", offset_frames="-1001", rotation_order="zxy")
    assert done["words"].startswith("Camera of plate.chan imported:")
    assert "The background of the film stands still" in done["detail"]
    assert done["doubtful"] is True
    desk.undo()


def test_of_several_animals_one_is_chosen(desk: Desk) -> None:
    id, state = desk.recognised("mice.csv", sleap("anna", "bert"))
    assert state["found"]["facts"]["individuals"] == ["anna", "bert"], state
    assert "2 individuals, anna and bert." in desk.imported(id, "keypoints")["words"]
    state = desk.imported(id, "keypoints", individual="bert", every="1")
    assert state["words"] == "All of these frames are posed already: choose others."


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("points.h5", b"\x89HDF\r\n\x1a\n" + bytes(64), "points.h5"),
        ("poses.pkl", b"cos\nsystem\n(S'true'\ntR.", "poses.pkl"),
        ("../../etc/x.bvh", b"", "x.bvh is empty"),
    ],
)
def test_what_cannot_be_read_is_refused_in_a_sentence_and_changes_nothing(
    desk: Desk, name: str, content: bytes, words: str
) -> None:
    before = desk.session.read_bytes()
    status, answer = desk.ask(f"/imports?name={quote(name)}", "POST", content)
    state = desk.until_over(answer["id"]) if status == 200 else answer
    assert words in state["words"], state
    assert state["words"].endswith(".")
    assert desk.session.read_bytes() == before


def test_an_import_that_is_over_is_reported_so(desk: Desk) -> None:
    assert desk.ask("/imports/0", "POST", b"{}")[0] == 404
    assert desk.ask("/imports/0")[0] == 404
