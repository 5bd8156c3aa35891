"""Pictures in rows, to look at side by side."""

from __future__ import annotations

from collections.abc import Sequence

import cv2
import numpy as np

from keypose.app.render.lettering import plate
from keypose.app.render.palette import GAP, Picture
from keypose.app.render.pictures import _letter_px, _stacked


def contact_sheet(
    images: Sequence[Picture], columns: int, labels: Sequence[str] | None = None
) -> Picture:
    """Pictures in rows of `columns`, each resampled to the first one's size and named."""
    if not images:
        raise ValueError("a contact sheet needs at least one picture")
    height, width = images[0].shape[:2]
    cells = [
        np.array(cv2.resize(image, (width, height), interpolation=cv2.INTER_AREA), dtype=np.uint8)
        for image in images
    ]
    for cell, words in zip(cells, labels or [], strict=bool(labels)):
        plate(cell, words, 4, 4, _letter_px(height))
    gap = max(2, height // 120)
    blank = np.full_like(cells[0], GAP)
    cells += [blank] * (-len(cells) % columns)
    rows = [_stacked(cells[i : i + columns], gap, axis=1) for i in range(0, len(cells), columns)]
    return _stacked(rows, gap, axis=0)
