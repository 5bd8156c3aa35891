"""Any edit, look or job at the page, at random; and what jobs may find, for edits to follow on."""

from __future__ import annotations

import json
import random
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
from pydantic import BaseModel

from keypose.app.editor import actions
from keypose.app.editor.posing import Drag
from keypose.app.jobs.ahead import FollowAhead
from keypose.app.jobs.draft import DraftClip, Drafted
from keypose.app.jobs.find_camera import FindCamera
from keypose.app.jobs.fit_pose import FitPose, FoundPose
from keypose.app.jobs.fit_sizes import FitSizes
from keypose.app.jobs.job import Failed, Finished, Job, Progress
from keypose.app.jobs.reduce import ReduceMotion
from keypose.app.jobs.space import SolveSpace
from keypose.app.jobs.stand import StandOnFloor
from keypose.app.jobs.track import Track
from keypose.app.posing import handles, with_height
from keypose.tracker.body.body import preset
from keypose.tracker.body.pose import Pose
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.body.trajectory import interpolate
from keypose.tracker.errors import KeyposeError, VideoError
from keypose.tracker.fitting.draft import ClipDraft
from keypose.tracker.fitting.draft import Proposal as DraftProposal
from keypose.tracker.fitting.sizes import Proposal, SizesFitted
from keypose.tracker.geometry.camera_path import CameraPath
from keypose.tracker.geometry.rotations import exp_rotation
from keypose.tracker.keypoints.keypoints import JOINTS, Keypoints
from keypose.tracker.operations.find_camera import FoundCamera
from keypose.tracker.session import Session
from keypose.tracker.session.annotations import Stop
from keypose.tracker.session.camera_motion import CameraMotion
from keypose.tracker.storage.sidecars import save_first_motion
from keypose.tracker.tracking.ahead.follow import FoundAhead
from keypose.tracker.video import Video
from tests.app.jobs.job_cases import reported, segment_done
from tests.app.store.test_store import _track
from tests.app.working.test_fitting import Desk, Worker
from tests.tracker.operations.space_cases import solution

LEFT_OUT = (
    actions.Open, actions.Close, actions.RenameSession, actions.DuplicateSession,
    actions.DeleteSession, actions.RestoreSession,
)  # fmt: skip
"""Which lead to another session."""
KINDS: tuple[type[BaseModel], ...] = tuple(
    kind
    for kind in (
        *actions.MESSAGES, *actions.Running.__args__, *actions.PoseKeeping.__args__,
        actions.InsertPose,
    )
    if kind not in LEFT_OUT
)  # fmt: skip
FRAMES = (0, 1, 12, 24, 25, 30, 48, 60, 71, 72, 73, 500, 10**6)
NUMBERS = (0.0, 0.5, -0.5, 1.0, 3.0, -20.0, 45.0, 90.0, 200.0, 400.0, 9000.0, 1e5)
OFTEN = (
    "clavicles", "add_part", "delete_part", "preset", "go", "reduce", "apply_reduction",
    "undo", "redo", "add_key", "delete_key", "track", "root", "drag",
    "live", "select",
)  # fmt: skip
"""Drawn more often than others: after these much is another."""


class WithoutFilm:
    """What a job has at hand, but for the film."""

    def video(self, *_: Any) -> Video:
        raise VideoError("The film is not there.")


@cache
def schema_of(kind: type[BaseModel]) -> dict[str, Any]:
    return kind.model_json_schema()


class RandomEdits:
    """Acts on a desk, one of many things at a time."""

    def __init__(self, desk: Desk, seed: int) -> None:
        self.desk, self.random, self.done = desk, random.Random(seed), list[str]()
        self._by_name = {schema_of(kind)["properties"]["do"].get("const"): kind for kind in KINDS}

    def act(self) -> None:
        """An action of a page, or the end of a job that is under way."""
        chance, waits = self.random.random(), self.desk.store.app_state
        if waits.preview is not None and chance < 0.5:
            self._send(actions.ApplySizes if chance < 0.3 else actions.DiscardSizes)
        elif waits.reduction is not None and not waits.reduction.busy and chance < 0.5:
            self._send(actions.ApplyReduction if chance < 0.4 else actions.DiscardReduction)
        elif chance < 0.2:
            self._end_a_job()
        elif chance < 0.23:
            self._import()
        elif chance < 0.5:
            self._send(self._by_name.get(self.random.choice(OFTEN)) or self._any())
        else:
            self._send(self._any())

    def _any(self) -> type[BaseModel]:
        return self.random.choice(KINDS)

    def _send(self, kind: type[BaseModel]) -> None:
        schema = schema_of(kind)
        message = self._value(schema, schema, "")
        if kind is Drag:
            message |= self._pull()
        if kind is actions.Reduce and self.random.random() < 0.9:
            goal = self.random.choice(({"cm": 3.0}, {"px": 5.0}, {"every": 20}))
            message = {"do": "reduce", "replacing": self.random.random() < 0.7, **goal}
        self.done.append(f"{message['do']} {json.dumps(message)[:300]}")
        self.desk.do(message)

    def _pull(self) -> dict[str, Any]:
        """A pull at what the body has to be pulled by."""
        pick, body = self.random.choice, self.desk.edit.doc.subject.body
        handle = pick(handles(body))
        ends = [
            [300.0 + 80 * self.random.random(), 200.0 + 80 * self.random.random()] for _ in "ab"
        ]
        kinds = (
            {"kind": "end", "name": handle.name},
            {"kind": "surface", "part": pick(body.names), "tool": pick(("move", "rotate"))},
        )
        views = ("main", "top", "side", "front")
        return {"handle": pick(kinds), "view": pick(views), "from": ends[0], "at": ends[1]}

    # --- messages by their schema

    def _value(self, schema: Mapping[str, Any], root: Mapping[str, Any], name: str) -> Any:
        pick = self.random.choice
        if "$ref" in schema:
            target = schema["$ref"].rsplit("/", 1)[1]
            return self._value(root["$defs"][target], root, target if target == "Body" else name)
        if name == "Body":
            names = ("adult_female", "child", "dog", "box", "cylinder")
            return preset(pick(names)).model_dump(mode="json")
        if "const" in schema:
            return schema["const"]
        if "enum" in schema:
            return pick(schema["enum"])
        for union in ("anyOf", "oneOf"):
            if union in schema:
                return self._value(pick(schema[union]), root, name)
        match schema.get("type"):
            case "object":
                return self._object(schema, root)
            case "array":
                return self._array(schema, root, name)
            case "integer":
                low, high = schema.get("minimum", 0), schema.get("maximum", 10**6)
                return min(max(pick(FRAMES), low), high)
            case "number":
                low, high = schema.get("minimum", -1e9), schema.get("maximum", 1e9)
                return min(max(pick(NUMBERS), low), high)
            case "boolean":
                return pick((True, False))
            case "string":
                return self._string(schema, name)
            case _:
                return None

    def _object(self, schema: Mapping[str, Any], root: Mapping[str, Any]) -> dict[str, Any]:
        needed = schema.get("required", ())
        if "properties" not in schema:
            inside, names = schema.get("additionalProperties"), self._names()
            if not isinstance(inside, dict):
                return {}
            return {self.random.choice(names): self._value(inside, root, "") for _ in range(3)}
        return {
            name: self._value(inside, root, name)
            for name, inside in schema["properties"].items()
            if name in needed or "const" in inside or self.random.random() < 0.4
        }

    def _array(self, schema: Mapping[str, Any], root: Mapping[str, Any], name: str) -> list[Any]:
        if "prefixItems" in schema:
            made = [self._value(inside, root, name) for inside in schema["prefixItems"]]
            is_turn = len(made) == 4 and "rotations" in name
            return [1.0, 0.0, 0.0, 0.0] if is_turn else made
        low = schema.get("minItems", 0)
        count = max(low, min(self.random.randrange(3), schema.get("maxItems", 3)))
        return [self._value(schema.get("items", {}), root, name) for _ in range(count)]

    def _names(self) -> tuple[str, ...]:
        return self.desk.edit.doc.subject.body.names

    def _string(self, schema: Mapping[str, Any], name: str) -> str:
        pick, body = self.random.choice, self.desk.edit.doc.subject.body
        if name == "stroke":
            return pick(("a", "b"))
        if name == "key":
            return pick(("length", "radius", "width", "depth", "height", "end"))
        if name == "name" and "pattern" not in schema:
            return pick(("hat", "tail", "adult_male", "dog", "box", *body.names))
        if schema.get("pattern", "").startswith("^[0-9a-f]"):
            return "0" * 12
        return pick(body.names) if self.random.random() < 0.9 else "nothing"

    # --- the ends of jobs

    def _end_a_job(self) -> None:
        """One of the jobs that are under way ends: as it may in earnest, cancelled, or failed."""
        pending = {number: item.job for number, item in self.desk.store._queue._items.items()}
        if not pending:
            return
        number = self.random.choice(list(pending))
        job, worker = pending[number], Worker.newest
        self.done.append(f"{type(job).__name__} ends")
        if self.random.random() < 0.1:
            worker.report(Failed(number, "It failed."))
        elif isinstance(job, Track):
            self._end_tracking(number, job)
        elif isinstance(job, SolveSpace):
            for stretch in job.stretches if "left_hand" in self._names() else ():
                worker.report(Progress(number, 1.0, partial=solution(stretch)))
            worker.report(Finished(number))
        elif isinstance(job, ReduceMotion | StandOnFloor):
            for report in reported(job, WithoutFilm()):
                worker.report(replace(report, job=number))
        else:
            found = self._found(job)
            worker.report(Finished(number, found) if found else Finished(number, cancelled=True))

    def _end_tracking(self, number: int, job: Track) -> None:
        doc, worker = Session.model_validate_json(job.session), Worker.newest
        keyed = {keyframe.frame for keyframe in doc.subject.keyframes}
        for one in job.wanted:
            if {*one[:2]} <= keyed and self.random.random() < 0.8:
                worker.report(segment_done(number, _track(doc, *one)))
        worker.report(Finished(number))

    def _found(self, job: Job) -> Any:
        doc = Session.model_validate_json(job.session)  # type: ignore[attr-defined]
        skeleton = Skeleton.of(doc.subject.body)
        last = doc.view.video.frame_count - 1
        if isinstance(job, FitPose):
            return FoundPose(_moved(job.pose), True, "Moved.")
        if isinstance(job, FitSizes):
            poses = {k.frame: k.pose(skeleton) for k in doc.subject.keyframes}
            body = doc.subject.body
            with suppress(KeyposeError):
                body = with_height(body, 150 + 50 * self.random.random())
            change = (body.names[0], "length", 40.0, 42.0)
            alone = Proposal(body, doc.view.camera, poses, (change,), 5.0, {})
            return SizesFitted("Sizes.", 6.2, alone, replace(alone, error_px=4.0), ())
        if isinstance(job, DraftClip):
            body = preset(self.random.choice(("adult_male", "child")))
            pose = Pose.rest(Skeleton.of(body), (0.0, 0.0, 4.0))
            first = self.random.randrange(last)
            frames = range(first, self.random.randrange(first, last) + 1)
            keypoints = Keypoints(
                0, JOINTS, np.full((5, len(JOINTS), 2), 7.0), np.ones((5, len(JOINTS)))
            )
            proposals = (DraftProposal(frames[0], "start"),)
            judged: Any = None
            draft = ClipDraft(body, dict.fromkeys(frames, pose), keypoints, proposals, judged)
            return [Drafted(draft, "abc", None)]
        if isinstance(job, FindCamera):
            return FoundCamera("turns", _panning(last + 1), None, (), None)
        if isinstance(job, FollowAhead):
            return _followed(doc, job.frame, job.direction == "forward")
        return None

    # --- files

    def _import(self) -> None:
        """A motion of another program is imported."""
        edit, opened = self.desk.edit, self.desk.store.opened
        if opened is None or edit.stroke is not None or not edit.keys:
            return
        self.done.append("import")
        pose = edit.doc.subject.keyframes[0].pose(edit.skeleton)
        motion = interpolate(pose, _moved(pose), 0, edit.frame_count - 1)
        doc = save_first_motion(edit.doc, opened.session_path, motion, "walk.bvh", {})
        self.desk.store._edit_to(edit.with_step(doc, "import"))


def _moved(pose: Pose) -> Pose:
    return Pose(pose.Rs_parent_part, pose.p_camera_root + np.array([0.05, 0.0, 0.02]))


def _panning(frames: int) -> CameraMotion:
    Ts = np.tile(np.eye(4), (frames, 1, 1))
    Ts[:, :3, :3] = [exp_rotation([0.0, 0.002 * frame, 0.0]) for frame in range(frames)]
    zoom = np.linspace(1.0, 1.1, frames)
    return CameraMotion.of("turns", CameraPath(Ts, zoom), np.full(frames, 0.1))


def _followed(doc: Session, frame: int, forward: bool) -> Any:
    keyframe = next((k for k in doc.subject.keyframes if k.frame == frame), None)
    if keyframe is None:
        return None
    pose = keyframe.pose(Skeleton.of(doc.subject.body))
    end = min(frame + 9, doc.view.video.frame_count - 1) if forward else max(frame - 9, 0)
    if end == frame:
        return None
    first, last = min(frame, end), max(frame, end)
    motion = interpolate(pose, pose, first, last)
    return FoundAhead(frame, "forward" if forward else "backward", motion, Stop(cause="limit"))
