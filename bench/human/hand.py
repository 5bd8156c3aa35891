"""The hand that poses: it sees pictures and marks, and errs.

A joint is put right when it looks wrong by more than `LOOKS_RIGHT_PX`. The order is that of the
guide: the body, its trunk, the head, hands and feet, then elbows and knees, then depth from the
side. A part that is turned stops within 2° of where it should; a joint that is dragged is as right
as it is seen.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from bench.human.desk import Desk
from keypose.app.editor.posing import Drag, Face, TurnInDepth
from keypose.app.editor.shown import shown_pose
from keypose.app.editor.update import Select
from keypose.app.posing import handles
from keypose.app.posing.gesture import Axis, End, Middle, Ring, Root, Surface
from keypose.app.posing.handles import BodyHandle, handle_named
from keypose.app.posing.moving import RISE_TO_E
from keypose.app.posing.pointer_view import PointerView
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.errors import KeyposeError
from keypose.tracker.geometry.rotations import Array, log_rotation

LOOKS_RIGHT_PX = 7.0
PLACED_PX = 5.0
"""A joint that is nearer looks right: with what it may be seen wrongly by it is within 10 px. The
whole body is carried more finely, for everything hangs on it."""
TURN_DEG = 2.0
SEEN_DEG = 35.0
FAR_PX = 25.0
"""A trunk turned by less is not seen to be; a body farther from its hips is carried there."""
TURN_GAIN = 0.2
"""A drag that takes a smaller share of the error of what it moves is cancelled."""
LIMB_GAIN = 0.1
"""The same of the error of a limb: what brings one joint nearer and another off is not done."""
DEEP_M = 0.2
DEPTH_SIGMA_M = 0.03
"""A hand or foot so much too near or too far is seen to be in the side view; and how well it is put
right there."""
BENDS_M = (0.0, 0.05, -0.05, 0.1, -0.1, 0.15, -0.15)
"""How much beside that it is put until elbow or knee fit."""
SIZE_SHARE = 0.04
SIZE_SIGMA = 0.015
"""A body that is larger or smaller by less is not seen to be; and how well it is made as large."""
NEARER = 0.8
"""A drag that leaves more than this share of the way is cancelled."""
ROUNDS = 3
AXES: tuple[Axis, ...] = ("x", "y", "z")
HIPS = ("left_thigh", "right_thigh", "hips")
SHOULDERS = ("left_upper_arm", "right_upper_arm")
TRUNK = (*HIPS, *SHOULDERS, "head_top")


@dataclass(frozen=True, eq=False)
class Hand:
    """One person's hand at a desk.

    by_picture: whether they look at the picture as it is: a body counts as too small or too large
    by how it is seen, not by how far away it is understood to be; and where marks are carried on
    from other frames, what these are off by is not taken for the body's.
    """

    desk: Desk
    random: np.random.Generator
    by_picture: bool = False

    @classmethod
    def of(cls, desk: Desk, seed: int, by_picture: bool = False) -> Hand:
        return cls(desk, np.random.default_rng([seed, 7]), by_picture)

    def looks_right(self) -> bool:
        """Whether no joint of the present frame looks wrong."""
        return not self.wrong()

    def wrong(self, least_px: float = LOOKS_RIGHT_PX) -> list[str]:
        """The joints that look wrong, the worst first."""
        unsure, least_px = self.desk.clip.unmeasured, least_px + self.slack_px(self.desk.frame)
        off = {n: px(way) for n, way in self.desk.off().items() if n not in unsure}
        return sorted((n for n in off if off[n] > least_px), key=lambda n: -off[n])

    def slack_px(self, frame: int) -> float:
        """How far off marks are themselves."""
        return self.desk.clip.slack_px(frame) if self.by_picture else 0.0

    def correct(self) -> None:
        """Pose the present frame until it looks right, or nothing more helps."""
        self._face()
        for _ in range(ROUNDS):
            before = len(self.desk.script)
            self._match_size()
            self.carry()
            self._turn("waist")
            self._turn("chest")
            self._pull_corners()
            self._turn_head()
            self._bow()
            self._pull("end")
            self._pull("middle")
            self._set_depth()
            if len(self.desk.script) == before or not self.wrong():
                return

    def correct_limbs(self) -> None:
        """The same for arms and legs alone."""
        for _ in range(ROUNDS):
            before = len(self.desk.script)
            self._pull("end")
            self._pull("middle")
            if len(self.desk.script) == before or not self.wrong():
                return

    # --- the body

    def _face(self) -> None:
        """Before anything is posed, face it as the person does, by one of the four buttons."""
        desk = self.desk
        if desk.keys or desk.state.doc.subject.drafts:
            return
        wanted = desk.clip.poses[desk.frame].Rs_parent_part[0]
        ways = [Face(way=way) for way in ("camera", "away", "left", "right")]
        found = [shown_pose(desk.tried(way)).pose.Rs_parent_part[0] for way in ways]
        off = [px(log_rotation(R.T @ wanted)) for R in found]
        desk.act("click", "face the body", ways[int(np.argmin(off))])

    def _match_size(self) -> None:
        """Farther or nearer until the body is as large as the person: with D held, one drag."""
        desk = self.desk
        farther = self._too_large() if self.by_picture else self._too_close()
        if abs(farther) > SIZE_SHARE:
            farther += float(self.random.normal(0.0, SIZE_SIGMA))
            rise = farther * RISE_TO_E * desk.state.doc.view.camera.height
            message = self._moved(np.array([0.0, -rise]), depth=True)
            desk.act("drag", "match the size", message)

    def _too_close(self) -> float:
        """The logarithm of how much farther away than the body the person is understood to be."""
        poses = self.desk.clip.poses[self.desk.frame], self.desk.shown().pose
        return float(np.log(np.divide(*(pose.p_camera_root[2] for pose in poses))))

    def _too_large(self) -> float:
        """The logarithm of how much larger than the person the body is seen: how far their joints
        are from the middle of all."""
        drawn, off = self.desk.project(self.desk.shown().pose), self.desk.off()
        at = np.stack([drawn[n] for n in off])
        both = at, at + np.stack(list(off.values()))
        return float(np.log(np.divide(*(np.ptp(uv, axis=0).max() for uv in both))))

    def carry(self) -> None:
        """Carry the body to where its hips, or its shoulders, are seen while it is far off."""
        off = self.desk.off()
        hips = [off[n] for n in HIPS if n in off] or [off[n] for n in SHOULDERS if n in off]
        if hips and px(np.mean(hips, axis=0)) > FAR_PX:
            self.desk.act("drag", "move the body", self._moved(np.mean(hips, axis=0)))

    @property
    def _trunk(self) -> list[str]:
        """The joints of the trunk that anybody is sure of."""
        return [n for n in (*HIPS, *SHOULDERS) if n not in self.desk.clip.unmeasured]

    def _carried(self) -> Drag | None:
        """The body carried to where its trunk is seen; None where it is there."""
        off = self.desk.off()
        trunk = [off[n] for n in self._trunk if n in off]
        way = np.mean(trunk, axis=0) if trunk else np.zeros(2)
        return self._moved(way) if px(way) > PLACED_PX else None

    def _moved(self, way: Array, depth: bool = False) -> Drag:
        """The body dragged by pixels (2,), its limbs staying or coming along."""
        stay = self.desk.as_drag(Root(kind="root"), way, "main", depth=depth)
        return self._stay_or_along(stay, list(self.desk.off()))

    def _stay_or_along(self, stay: Drag, joints: Sequence[str]) -> Drag:
        """A drag, or the same with Alt, by which what would stay comes along: whichever brings
        joints nearer to where they are seen."""
        along = stay.model_copy(update={"carry": True})
        return max((stay, along), key=lambda message: self._gain(message, joints))

    # --- parts

    def _pull_corners(self) -> None:
        """Drag shoulders and hips that look wrong onto where they are seen, and the body onto where
        the trunk is, each time what brings the trunk nearest, as long as that helps."""
        trunk = self._trunk
        for _ in trunk:
            tries = [("move the body", self._carried())]
            for handle in handles(self.desk.state.doc.subject.body):
                if handle.kind == "corner" and handle.anchor in self.wrong():
                    message = self._onto(_grip(handle), handle.anchor)
                    tries.append(("pull a shoulder or a hip", message))
            gains = [0.0 if message is None else self._gain(message, trunk) for _, message in tries]
            best = int(np.argmax(gains))
            if gains[best] <= TURN_GAIN:
                break
            self.desk.act("drag", *tries[best])

    def _turn(self, part: str) -> None:
        """Turn a part of the trunk that plainly faces another way than the person's by its rings,
        until it does not."""
        joints = (*HIPS, *SHOULDERS) if part == "waist" else (*SHOULDERS, "head_top")
        selected = False
        for _ in AXES:
            turns = [turn for turn in self._turned(part) if abs(turn[1]) >= SEEN_DEG]
            if not turns:
                break
            ring, deg, gain = self._best_turn(part, turns, joints)
            if self.by_picture and gain < -LIMB_GAIN:
                break  # what is seen would no longer be where it is
            if not selected:
                self.desk.act("click", f"select the {part}", Select(part=part))
                selected = True
            slip = float(self.random.normal(0.0, TURN_DEG))
            self.desk.turn(f"turn the {part}", ring, deg + slip)

    def _turned(self, part: str) -> list[tuple[Axis, float]]:
        """By how many degrees a part would have to be turned about each of its own axes to lie as
        the person's does."""
        desk, index = self.desk, self.desk.state.doc.subject.body.index(part)
        poses = desk.shown().pose, desk.clip.poses[desk.frame]
        now, wanted = (pose_transforms(desk.state.skeleton, p)[index, :3, :3] for p in poses)
        off_deg = np.degrees(log_rotation(now.T @ wanted))
        return list(zip(AXES, off_deg.tolist(), strict=True))

    def _best_turn(
        self, part: str, turns: Sequence[tuple[Axis, float]], joints: Sequence[str]
    ) -> tuple[Ring, float, float]:
        """The ring that brings joints nearest, its angle, and the share of their error it takes."""
        tries = []
        for axis, deg in turns:
            ring = Ring(kind="ring", part=part, axis=axis)
            tries.append((self._gain(self.desk.as_turn(ring, deg), joints), -abs(deg), ring, deg))
        gain, _, ring, deg = max(tries, key=lambda t: t[:2])
        return ring, deg, gain

    def _gain(self, message: Drag, joints: Sequence[str]) -> float:
        """The share that a drag takes of what these joints are off."""
        found, before = self._pose_after(message), self._error(joints)
        return 0.0 if found is None or not before else 1.0 - self._error(joints, found) / before

    def _error(self, joints: Sequence[str], pose: Pose | None = None) -> float:
        """Root mean square of what those of the joints that are seen are off."""
        off = self.desk.off(pose=pose)
        known = [px(off[n]) ** 2 for n in joints if n in off]
        return float(np.sqrt(np.mean(known))) if known else 0.0

    def _bow(self) -> None:
        """Drag the head, and with it the trunk, where that brings head and shoulders nearer."""
        if self._is_off("head_top") and any(map(self._is_off, SHOULDERS)):
            message = self._onto(End(kind="end", name="head"), "head_top")
            if self._gain(message, (*SHOULDERS, "head_top")) > TURN_GAIN:
                self.desk.act("drag", "pull the head", message)

    def _turn_head(self) -> None:
        """Turn the head by its surface until its top is where it is seen."""
        if self._is_off("head_top"):
            top = self.desk.project(self.desk.shown().pose)["head_top"]
            head = Surface(kind="surface", part="head", tool="rotate")
            self._drag_if_it_helps("turn the head", head, "head_top", top)

    def _pull(self, kind: str) -> None:
        """Drag every handle of a kind whose joint looks wrong onto where the joint is seen. Where
        an elbow or a knee does not get there, its hand or foot is too near or too far."""
        for handle in handles(self.desk.state.doc.subject.body):
            joint = handle.anchor
            if handle.kind != kind or not self._is_off(joint):
                continue
            if kind == "middle" and not self._helps(self._limb_drag(handle), joint):
                self._bend(handle)
            message = self._limb_drag(handle)
            if self._is_off(joint) and self._gain(message, self._seen_of(handle)) > LIMB_GAIN:
                self._do_if_it_helps(f"pull {_word(handle)}", message, joint)

    def _limb_drag(self, handle: BodyHandle) -> Drag:
        """A handle of a limb dragged onto where its joint is seen; the limb's others stay or come
        along."""
        drag = self._onto(_grip(handle), handle.anchor)
        return self._stay_or_along(drag, self._seen_of(handle))

    def _seen_of(self, handle: BodyHandle) -> list[str]:
        """The joints of a handle's limb that are looked at."""
        return [name for name in handle.limb if name in self.desk.clip.places]

    def _is_off(self, joint: str) -> bool:
        return joint in self.wrong()

    def _drag_if_it_helps(
        self, why: str, grip: Any, joint: str, start: Array | None = None
    ) -> None:
        """Drag until a joint is where it is seen; where that leads nowhere a person cancels."""
        self._do_if_it_helps(why, self._onto(grip, joint, start), joint)

    def _do_if_it_helps(self, why: str, message: Drag, joint: str) -> None:
        if self._helps(message, joint):
            self.desk.act("drag", why, message)

    def _onto(self, grip: Any, joint: str, start: Array | None = None) -> Drag:
        begin = np.zeros(2) if start is None else start
        return self.desk.as_drag(grip, self.desk.off()[joint], "main", begin)

    def _helps(self, message: Drag, joint: str) -> bool:
        """Whether a drag brings a joint nearer."""
        desk = self.desk
        found = self._pose_after(message)
        return found is not None and px(desk.off(pose=found)[joint]) < NEARER * px(
            desk.off()[joint]
        )

    # --- depth

    def _set_depth(self) -> None:
        """Hands and feet that are much too near or too far, as the side view shows."""
        for handle in handles(self.desk.state.doc.subject.body):
            if handle.kind == "end":
                self._set_depth_of(handle.name, DEEP_M)

    def _set_depth_of(self, name: str, least_m: float) -> None:
        """A hand or a foot, if it is so much too near or too far."""
        handle = handle_named(self.desk.state.doc.subject.body, name)
        if handle.anchor not in self.desk.clip.places or abs(self._too_near(handle)) < least_m:
            return
        if self.by_picture and self._turn_in_depth(handle):
            return
        slip = float(self.random.normal(0.0, DEPTH_SIGMA_M))
        message = self._farther(handle, self._too_near(handle) + slip)
        found = self._pose_after(message)
        left = None if found is None else self._too_near(handle, found)
        if self.by_picture and self._gain(message, self._seen_of(handle)) < -LIMB_GAIN:
            return  # what is seen would no longer be where it is
        if left is not None and abs(left) < NEARER * abs(self._too_near(handle)):
            self.desk.act("drag", "set depth", message)

    def _turn_in_depth(self, handle: BodyHandle) -> bool:
        """A limb that points to the camera instead of away from it, or its lower part, turned by
        its menu, where it then is seen as well; whether there was one."""
        desk, before = self.desk, abs(self._too_near(handle))
        tries = []
        for part in handle.limb[:2]:
            message = TurnInDepth(part=part)
            found = self._pose_after(message)
            if found is None or self._error(self._seen_of(handle), found) > LOOKS_RIGHT_PX:
                continue
            left = abs(self._too_near(handle, found))
            if left < NEARER * before:
                tries.append((left, message))
        if not tries:
            return False
        desk.act("click", "turn in depth: the limb's menu")
        desk.act("click", "turn in depth", min(tries, key=lambda t: t[0])[1])
        return True

    def _bend(self, middle: BodyHandle) -> None:
        """Drag a hand or foot nearer or farther until elbow or knee are where they are seen; about
        as near or far as it is understood to be."""
        end, joint = handle_named(self.desk.state.doc.subject.body, middle.limb[-1]), middle.anchor
        if end.anchor not in self.desk.clip.places:
            return
        tries = []
        for beside_m in BENDS_M:
            message = self._farther(end, self._too_near(end) + beside_m)
            left = self._bent_by(message, middle)
            if left is not None:
                tries.append((left, abs(beside_m), message))
        if tries:
            left, _, message = min(tries, key=lambda t: t[:2])
            if left < NEARER * px(self.desk.off()[joint]):
                self.desk.act("drag", "set depth", message)

    def _bent_by(self, message: Drag, middle: BodyHandle) -> float | None:
        """How far off an elbow or a knee would be after a drag, and after it is pulled itself."""
        desk, joint = self.desk, middle.anchor
        try:
            found = shown_pose(desk.tried(message)).pose
            pull = desk.as_drag(_grip(middle), desk.off(pose=found)[joint], "main")
            then = shown_pose(desk.tried(message, pull)).pose
        except KeyposeError:
            return None
        return min(px(desk.off(pose=pose)[joint]) for pose in (found, then))

    def _pose_after(self, message: Drag | TurnInDepth) -> Pose | None:
        """The pose that a drag would lead to; None where it cannot be had."""
        try:
            return shown_pose(self.desk.tried(message)).pose
        except KeyposeError:
            return None

    def _too_near(self, handle: BodyHandle, pose: Pose | None = None) -> float:
        """Metres by which an end is nearer than it is understood to be, seen from the waist."""
        desk = self.desk
        ours = self._depth(pose or desk.shown().pose, handle.anchor)
        return self._depth(desk.clip.poses[desk.frame], handle.anchor) - ours

    def _farther(self, handle: BodyHandle, by_m: float) -> Drag:
        """Dragged along its line of sight, with D held: up is farther."""
        view = PointerView.of(self.desk.state.doc.view.camera)
        p = self.desk.points(self.desk.shown().pose)[handle.anchor]
        rise = by_m / float(view.ray_through(p)[2]) / view.metres_per_unit(p)
        return self.desk.as_drag(_grip(handle), np.array([0.0, -rise]), "main", depth=True)

    def _depth(self, pose: Pose, joint: str) -> float:
        """How much farther than the waist a joint is, metres."""
        Ts = pose_transforms(self.desk.state.skeleton, pose)
        return float(self.desk.points(pose)[joint][2] - Ts[0, 2, 3])


def px(way: Array) -> float:
    """The length of a way."""
    return float(np.linalg.norm(way))


def _grip(handle: BodyHandle) -> Any:
    if handle.kind in ("middle", "corner"):
        return Middle(kind="joint", name=handle.name)
    return End(kind="end", name=handle.name)


def _word(handle: BodyHandle) -> str:
    if handle.kind == "middle":
        return "an elbow or knee"
    return f"a {handle.name.split('_')[-1]}"
