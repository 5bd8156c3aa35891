"""What a choice of network stands for: how each frame is looked at."""

from __future__ import annotations

from keypose.tracker.errors import KeypointError
from keypose.tracker.keypoints.animal_network import AnimalNetwork, animal_fingerprint
from keypose.tracker.keypoints.augmented import AugmentedNetwork, augmented_fingerprint
from keypose.tracker.keypoints.blazepose import BlazePose, fingerprint_of
from keypose.tracker.keypoints.joint_network import JointNetwork
from keypose.tracker.keypoints.model_files import FULL, Model
from keypose.tracker.keypoints.paired import PairedNetwork, paired_fingerprint


def open_detector(model: Model, *, fast: bool | None = None) -> AugmentedNetwork | PairedNetwork:
    """Read what looks at frames: BlazePose several times a frame, or BlazePose full and a network
    of joints once each. KeypointError as of `open_runtime` and `verified`, and of a network of
    animals."""
    if model.of_animals:
        raise KeypointError(
            f"The network {model.name!r} finds animals: choose another one for a person."
        )
    if model.heads is None:
        return AugmentedNetwork.open(model, fast=fast)
    return PairedNetwork(BlazePose.open(FULL, fast=fast), JointNetwork.open(model, fast=fast))


def open_animal_detector(model: Model, *, fast: bool | None = None) -> AnimalNetwork:
    """Read what looks at frames for an animal; KeypointError as of `JointNetwork.open`."""
    return AnimalNetwork(JointNetwork.open(model, fast=fast))


def detector_fingerprint(model: Model) -> str:
    """What the fingerprint of what looks at frames would be, with no network read."""
    if model.of_animals:
        return animal_fingerprint(fingerprint_of(model))
    if model.heads is None:
        return augmented_fingerprint(model)
    return paired_fingerprint(fingerprint_of(FULL), fingerprint_of(model))
