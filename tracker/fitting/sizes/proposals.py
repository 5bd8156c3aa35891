"""What is proposed from the sizes found: sizes alone, and sizes with limbs posed anew for them.

Wrong lengths were made up for by turns out of the picture, so right ones mostly ask for other
poses. These are proposed apart, for somebody to accept, and never lean or float more than before:
the trunk's turns are those that were set.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from keypose.tracker.body.body import Body
from keypose.tracker.body.modify import height, scaled
from keypose.tracker.body.pose import Pose, pose_transforms
from keypose.tracker.body.raster import BodyMesh
from keypose.tracker.body.skeleton import Skeleton
from keypose.tracker.fitting.sizes.beside import error_beside
from keypose.tracker.fitting.sizes.contours import ColourModels, offsets
from keypose.tracker.fitting.sizes.estimate import estimate
from keypose.tracker.fitting.sizes.messages import SizesFound, fitted_height, size_changes
from keypose.tracker.fitting.sizes.residuals import Pictures, contours
from keypose.tracker.fitting.sizes.shared import Shared, SharedFit
from keypose.tracker.geometry.camera import Camera
from keypose.tracker.geometry.rotations import Array, log_rotation, rotation_between
from keypose.tracker.solver.sigmas import CONTOUR_PX, PROPOSED_RAD, STIFF_RAD

UP_CAMERA = (0.0, -1.0, 0.0)
REACH_PX = 9.0
"""How far from the body its outline is looked for when errors are compared."""
ROUNDS_PX = (6.0, 5.0)
BETTER = 0.98
"""Share of the outline's error that may remain for a proposal to be made."""
FLOATING_M = 0.003
"""By how much more the height of the lowest foot may vary between keyframes."""
LESS = (1.0, 0.5, 0.25)
"""Shares of the turns that are tried, until the feet float no more than before."""
LEAST_TURN_DEG = 0.5


@dataclass(frozen=True, eq=False)
class Proposal:
    """A body, a camera and keyposes that agree better with the pictures.

    changes: (part, what, before, after), centimetres.  error_px: of the outline, then.
    turns: by frame, (part, degrees) of every part that is turned.  larger: how many times farther
    away all of it is; apart: and other films' cameras from the first.
    """

    body: Body
    camera: Camera
    keyposes: Mapping[int, Pose]
    changes: tuple[tuple[str, str, float, float], ...]
    error_px: float
    turns: Mapping[int, tuple[tuple[str, float], ...]]
    larger: float = 1.0
    apart: float = 1.0


@dataclass(frozen=True, eq=False)
class KeyframePictures:
    """The pictures of the keyframes at `frames`, looked at for proposals.

    camera: of the video.  scale: pixels of the pictures, in the video's.
    """

    fit: SharedFit
    camera: Camera
    pictures: Pictures
    looked: list[int]
    frames: Sequence[int]
    scale: float
    cancelled: Callable[[], bool]

    @cached_property
    def as_posed(self) -> Shared:
        return Shared(np.zeros(len(self.fit.free)), self.fit.posed)

    @cached_property
    def error_before(self) -> float:
        return self._error(self.as_posed)

    @property
    def _focal(self) -> int:
        """Where the focal length is among what is shared."""
        return self.fit.proportions.count

    @cached_property
    def _colours(self) -> ColourModels:
        return self.pictures.colour_models(contours(self.fit, self.as_posed, self.looked), self.fit)

    def alone(self, sizes_found: SizesFound) -> Proposal | None:
        """The sizes fitted again with every pose as it was set."""
        free = sizes_found.changed.copy()
        free[self._focal :] = False
        fit = replace(self.fit, free=free, poses_free=False, trunk_rad=STIFF_RAD)
        focal = np.zeros(len(free))
        focal[self._focal] = (sizes_found.shared.values * sizes_found.changed)[self._focal]
        start = fit.with_step(self.as_posed, focal)
        again = estimate(fit, start, self.pictures, self.looked, ROUNDS_PX, self.cancelled)
        if again is None:
            return None
        low, high = (pick(sizes_found.shared.values, 0.0) for pick in (np.minimum, np.maximum))
        values = np.clip(again.shared.values, low, high)  # not away from those found with poses
        values[self._focal + 2 :] = 0.0  # where a film's camera is follows from poses
        shared = replace(again.shared, values=values)
        return self._if_better(self._proposal(sizes_found, shared), shared)

    def with_poses(
        self, sizes_found: SizesFound, Ts_world_camera: Array, up: Sequence[float]
    ) -> Proposal | None:
        """The sizes found, and the limbs posed for them."""
        free = np.zeros_like(sizes_found.changed)
        fit = replace(self.fit, free=free, trunk_rad=STIFF_RAD, turns_rad=PROPOSED_RAD)
        start = fit.with_step(self.as_posed, sizes_found.shared.values)
        again = estimate(fit, start, self.pictures, self.looked, ROUNDS_PX, self.cancelled)
        if again is None:
            return None
        posed = [
            self._as_set(pose, s) for pose, s in zip(again.shared.poses, start.poses, strict=True)
        ]
        before = _floating(self.fit.proportions.body, self.fit.posed, Ts_world_camera, up)
        body = self.fit.proportions.body_at(sizes_found.shared.sizes)
        for share in LESS:
            poses = [_between(s, p, share) for s, p in zip(start.poses, posed, strict=True)]
            if _floating(body, poses, Ts_world_camera, up) <= before + FLOATING_M:
                shared = Shared(sizes_found.shared.values, tuple(poses))
                better = self._if_better(self._proposal(sizes_found, shared), shared)
                return better and _as_large(better, sizes_found)
        return None

    def larger(self, sizes_found: SizesFound) -> Proposal | None:
        """The same proportions as large as a measured distance of cameras shows; None where it
        shows nothing else."""
        if not sizes_found.changed[self._focal + 2 :].any():
            return None
        unchanged = replace(sizes_found, changed=np.zeros_like(sizes_found.changed))
        return _as_large(self._proposal(unchanged, self.as_posed), sizes_found)

    def _as_set(self, pose: Pose, start: Pose) -> Pose:
        """Put back the trunk's turns to the last digit as they were set."""
        is_trunk = self.fit.proportions.is_trunk[:, None, None]
        return Pose(
            np.where(is_trunk, start.Rs_parent_part, pose.Rs_parent_part), pose.p_camera_root
        )

    def _proposal(self, sizes_found: SizesFound, shared: Shared) -> Proposal:
        posed = replace(sizes_found, shared=shared)
        turns = {
            frame: frame_turns
            for frame, before, after in zip(self.frames, self.fit.posed, shared.poses, strict=True)
            if (frame_turns := self._turns(before, after))
        }
        camera = shared.focus(self.camera) if sizes_found.changed[self._focal] else self.camera
        return Proposal(
            self.fit.proportions.body_at(shared.sizes),
            camera,
            dict(zip(self.frames, shared.poses, strict=True)),
            size_changes(posed),
            self._error(shared),
            turns,
        )

    def _if_better(self, proposal: Proposal, shared: Shared) -> Proposal | None:
        """None unless it agrees better than what was posed."""
        error, before = proposal.error_px, self.error_before
        if self.fit.beside:
            error, before = self._missed(error, shared), self._missed(before, self.as_posed)
        return proposal if error < BETTER * before else None

    def _missed(self, outline_px: float, shared: Shared) -> float:
        """By how many sigmas the outline and the joints in other films are missed."""
        outline = outline_px / (self.scale * CONTOUR_PX) if np.isfinite(outline_px) else 0.0
        return float(np.hypot(outline, error_beside(self.fit, shared)))

    def _turns(self, before: Pose, after: Pose) -> tuple[tuple[str, float], ...]:
        turn = log_rotation(np.swapaxes(before.Rs_parent_part, -1, -2) @ after.Rs_parent_part)
        degrees = np.degrees(np.linalg.norm(turn, axis=-1))
        names = self.fit.proportions.body.names
        order = np.argsort(-degrees, kind="stable").tolist()
        return tuple((names[i], float(degrees[i])) for i in order if degrees[i] >= LEAST_TURN_DEG)

    def _error(self, shared: Shared) -> float:
        """Root mean square distance of the body's outline from the pictures', video pixels."""
        shown_contours = contours(self.fit, shared, self.looked)
        away = np.concatenate(
            [
                offsets(contour, self._colours, j, REACH_PX)
                for j, contour in enumerate(shown_contours)
            ]
        )
        known_away = away[np.isfinite(away)]
        return self.scale * float(np.sqrt((known_away**2).mean())) if known_away.size else np.inf


def _as_large(proposal: Proposal, sizes_found: SizesFound) -> Proposal:
    """All of it as large as other films tell, which the first one shows as before."""
    beside = sizes_found.beside
    if beside is None:
        return proposal
    apart = beside.larger * sizes_found.shared.apart
    if beside.sigma_share is None:
        return replace(proposal, apart=apart)
    larger = beside.larger * fitted_height(sizes_found) / height(proposal.body)
    poses = {
        frame: Pose(pose.Rs_parent_part, larger * pose.p_camera_root)
        for frame, pose in proposal.keyposes.items()
    }
    changes = tuple(
        (part, size, before, larger * after) for part, size, before, after in proposal.changes
    )
    body = scaled(proposal.body, larger)
    return replace(proposal, body=body, keyposes=poses, changes=changes, larger=larger, apart=apart)


def _floating(
    body: Body, poses: Sequence[Pose], Ts_world_camera: Array, up: Sequence[float]
) -> float:
    """By how much the height of the body's lowest point varies along up (3,) of the world,
    metres; Ts_world_camera (K, 4, 4) at the poses.
    """
    skeleton = Skeleton.of(body)
    mesh, up_world = BodyMesh.of(skeleton), np.asarray(up) / np.linalg.norm(up)
    lowest = [
        (mesh.posed(T @ pose_transforms(skeleton, pose)) @ up_world).min()
        for T, pose in zip(Ts_world_camera, poses, strict=True)
    ]
    return float(np.ptp(lowest))


def _between(start: Pose, end: Pose, share: float) -> Pose:
    """A share of the way from one pose to another."""
    if share == 1.0:
        return end
    Rs = rotation_between(start.Rs_parent_part, end.Rs_parent_part, [share])[0]
    p = start.p_camera_root + share * (end.p_camera_root - start.p_camera_root)
    return Pose(Rs, p)
