"""Find a person in what cameras took, step by step: silhouettes without a clean background."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from keypose.tracker.errors import KeypointError, SurfaceError
from keypose.tracker.keypoints.detect import Detector, Rows
from keypose.tracker.keypoints.region import Region
from keypose.tracker.surface.cameras.rig import Grey, Rig, RigCamera

LOOKS: Final = 4
"""At most, at each picture, every one where the person was seen the last time: so many lead from
the whole picture to the person."""


class PersonFinder:
    """Says where a person is in a camera's picture: where it was in the one before, or else in its
    box, or the whole picture where the file gives none."""

    def __init__(self, rig: Rig, network: Detector) -> None:
        """SurfaceError where a box is none."""
        self._network = network
        self._first = {camera.name: _first_region(camera) for camera in rig.cameras}
        self._last = dict(self._first)

    def __call__(self, name: str, picture: NDArray[np.uint8]) -> Grey | None:
        """The person's mask (H, W) in a picture (H, W, 3), RGB; None where nobody is."""
        height, width = picture.shape[:2]
        for region in dict.fromkeys((self._last[name], self._first[name])):
            rows = Rows.begun(region, self._network, picture, LOOKS)
            (mask,) = rows.stretch().masks
            if mask is not None:
                self._last[name] = rows.region
                return np.round(255 * mask.in_picture(width, height)).astype(np.uint8)
        return None


def _first_region(camera: RigCamera) -> Region:
    width, height = camera.width, camera.height
    if camera.box is None:
        return Region((width - 1) / 2, (height - 1) / 2, max(width, height))
    try:
        return Region.of_box(camera.box, width, height)
    except KeypointError as error:
        raise SurfaceError(f"Camera {camera.name!r}: {error}") from None
