"""How far cameras are apart counts as measured only where all of them were."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.session.between_views import measured_share
from keypose.tracker.session.views import Placed
from tests.app.film_beside_cases import with_film
from tests.tracker.session_cases import session

TAKEN_M = float(np.linalg.norm(with_film(session()).views[1].p_camera_world))


@pytest.mark.parametrize(
    ("placed", "share"),
    [
        (None, None),
        (Placed(source="body"), None),
        (Placed(source="file"), None),
        (Placed(source="file", measured_m=1.1 * TAKEN_M), 1.1),
    ],
)
def test_a_distance_is_measured_by_a_calibration_in_known_units(
    placed: Placed | None, share: float | None
) -> None:
    found = measured_share(with_film(session(), placed=placed))
    assert found == (share if share is None else pytest.approx(share))


def test_one_film_has_no_other_camera() -> None:
    assert measured_share(session()) is None
