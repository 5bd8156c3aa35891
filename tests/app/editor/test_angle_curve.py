"""The curve of a part's angles over the frames, and its keys dragged."""

from __future__ import annotations

import numpy as np

from keypose.app.editor.motion import angle_curve
from tests.app.editor.desk import after, desk

LEANING = {0: 0.0, 24: -60.0, 48: -120.0}
"""Degrees at keyframes, about x and about z."""


def test_a_key_dragged_on_the_curve_of_a_body_in_profile_leaves_its_other_angles() -> None:
    turns = [
        {"do": "key_angle", "frame": frame, "part": "waist", "axis": axis, "deg": deg}
        for frame, lean in LEANING.items()
        for axis, deg in (("x", lean), ("y", 84.0), ("z", lean))
    ]
    edit = after(desk(), *turns)
    np.testing.assert_allclose(angle_curve(edit, 0)[list(LEANING)], [
        [lean, 84.0, lean] for lean in LEANING.values()
    ], atol=1e-6)  # fmt: skip
    edit = after(edit, {"do": "key_angle", "frame": 48, "part": "waist", "axis": "x", "deg": -121})
    np.testing.assert_allclose(angle_curve(edit, 0)[48], [-121, 84, -120], atol=1e-6)
