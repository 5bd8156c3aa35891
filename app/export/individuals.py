"""Which individual of a file is which body of a session."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from keypose.tracker.errors import listed
from keypose.tracker.formats.joint_motion import JointMotion
from keypose.tracker.session.bodies import TrackedBody


@dataclass(frozen=True)
class Assignment:
    """Individuals by the ids of the bodies that they are.

    by_order: ids of bodies that got theirs by the order in the file, not by a name.
    left_out: individuals that are no body.  without: ids of bodies that are no individual.
    """

    individual_of: dict[str, str]
    by_order: tuple[str, ...]
    left_out: tuple[str, ...]
    without: tuple[str, ...]

    def sentences(self, file: str) -> list[str]:
        """Which went where, and what was left."""
        said = [
            f"{individual or file} → {body}"
            + (" by their order" if body in self.by_order and len(self.individual_of) > 1 else "")
            for body, individual in self.individual_of.items()
        ]
        words = [f"{file}: {', '.join(said)}."]
        if self.left_out:
            verb = "is" if len(self.left_out) == 1 else "are"
            words.append(f"{listed(self.left_out)} {verb} no body of the session: left out.")
        if self.without:
            words.append(f"Nothing in {file} for {listed(self.without)}.")
        return words


def assigned(
    individuals: Sequence[str],
    bodies: Sequence[TrackedBody],
    is_alike: Callable[[TrackedBody], bool],
) -> Assignment:
    """Individuals to bodies: those whose name is a body's id, or its own name alone, and the others
    in their order to the other bodies that are of their kind.

    is_alike: whether the file's names of joints or keypoints are a body's.
    """
    individual_of = {
        body.id: individual for individual in individuals for body in _called(individual, bodies)
    }
    rest = [name for name in individuals if name not in individual_of.values()]
    free = [body.id for body in bodies if body.id not in individual_of and is_alike(body)]
    by_order = dict(zip(free, rest, strict=False))
    every = individual_of | by_order
    ids = [body.id for body in bodies]
    return Assignment(
        {body_id: every[body_id] for body_id in ids if body_id in every},
        tuple(by_order),
        tuple(rest[len(by_order) :]),
        tuple(body_id for body_id in ids if body_id not in every),
    )


def individuals_of(motion: JointMotion, bodies: Sequence[TrackedBody]) -> tuple[str, ...]:
    """The individuals of a file of motion: subjects that share joints, or of whom one is called as
    a body."""
    owners = tuple(dict.fromkeys(filter(None, motion.owners)))
    is_called = any(_called(owner, bodies) for owner in owners)
    return owners if len(owners) > 1 and (motion.subjects or is_called) else ()


def _called(individual: str, bodies: Sequence[TrackedBody]) -> list[TrackedBody]:
    """The body of a name, where there is just one."""
    name = individual.casefold()
    by_id = [body for body in bodies if body.id == name]
    by_name = [body for body in bodies if body.body.name.casefold() == name]
    return by_id or (by_name if len(by_name) == 1 else [])
