"""From the state to what the four views show of it."""

from __future__ import annotations

from typing import Any

import numpy as np

from keypose.app.editor.documents import unchanged
from keypose.app.editor.frames import views_of
from keypose.app.editor.shown import bodies_beside, ghost_transforms, ghosts, shown_pose
from keypose.app.editor.state import EditorState
from keypose.app.render.palette import body_colour
from keypose.app.scene.scene import BodyBeside, Scenery, Trail
from keypose.app.scene.viser_compat import Role
from keypose.tracker.body.body import Body
from keypose.tracker.body.pose import pose_transforms
from keypose.tracker.geometry.rotations import Array

Ghosts = tuple[tuple[int, Array], ...]


class SceneryMaker:
    """What did not change keeps its identity, which is how the stage knows not to draw it again."""

    def __init__(self) -> None:
        self._made: dict[str, tuple[tuple[Any, ...], Any]] = {}

    def of(self, edit: EditorState, trail: Any = None) -> Scenery:
        """What is to be seen at the present frame; `trail` is the section of that name."""
        looks, settled = edit.display, edit.settled
        around = (settled.subject.body, settled.subject.keyframes, edit.frame, looks, edit.results)
        pose = shown_pose(edit).pose
        return Scenery(
            body=edit.doc.subject.body,
            Ts_camera_part=self._once(
                "pose", (edit.doc, edit.frame, edit.results), lambda: _transforms(edit, pose)
            ),
            selected=frozenset({edit.selected} if edit.selected else ()),
            mode=looks.mode,
            opacity=looks.opacity,
            ghosts=self._once("ghosts", (*around, settled.camera_path), lambda: _ghosts(edit)),
            trail=self._once("trail", (trail, edit.frame), lambda: _trail(trail, edit.frame)),
            Rs_view_camera=self._once("views", _where(edit), lambda: _views(edit)),
            beside=self._once(
                "beside",
                (edit.doc if edit.doc.bonds else edit.settled, edit.frame, edit.results),
                lambda: _beside(edit),
            ),
            before=self._once(
                "before", (edit.compared, edit.frame, edit.results), lambda: _before(edit)
            ),
            telephoto=edit.doc.view.camera.telephoto_distance_m is not None,
        )

    def _once(self, name: str, made_of: tuple[Any, ...], make: Any) -> Any:
        known = self._made.get(name)
        if known is not None and unchanged(known[0], made_of):
            return known[1]
        made = make()
        self._made[name] = (made_of, made)
        return made


def _transforms(edit: EditorState, pose: Any) -> Array:
    return pose_transforms(edit.skeleton, pose)


def _where(edit: EditorState) -> tuple[Any, ...]:
    """What the small views depend on."""
    path = edit.doc.camera_path
    return (edit.doc.world.up_world, path, None if path is None else edit.frame)


def _views(edit: EditorState) -> dict[Role, Array]:
    rotations, _ = views_of(edit.doc, edit.frame)
    return {"free": rotations["front"], **dict(rotations.items())}


def _ghosts(edit: EditorState) -> Ghosts:
    """The keyframes before and after the present frame, and a soft one's own pose here."""
    if not edit.display.ghosts:
        return ()
    return tuple((frame, ghost_transforms(edit, frame, pose)) for frame, pose in ghosts(edit))


def _beside(edit: EditorState) -> tuple[BodyBeside, ...]:
    """The bodies that are not posed, each in its colour."""
    return tuple(
        BodyBeside(body, Ts, body_colour(place)) for place, body, Ts in bodies_beside(edit)
    )


def _before(edit: EditorState) -> tuple[Body, Array] | None:
    """The body that is compared with, as it is posed at the present frame."""
    if edit.compared is None:
        return None
    compared = edit.with_doc(edit.compared)
    pose = shown_pose(compared).pose
    return compared.doc.subject.body, pose_transforms(compared.skeleton, pose)


def _trail(section: Any, frame: int) -> Trail | None:
    """The trail from the section that the page receives: it has been computed already."""
    if section is None:
        return None
    frames = [point[0] for point in section["points"]]
    present = min(range(len(frames)), key=lambda k: abs(frames[k] - frame))
    return Trail(np.array([point[1:] for point in section["points"]]), present)
