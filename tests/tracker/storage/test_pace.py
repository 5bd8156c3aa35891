"""How long a draft takes on this computer is known before it begins."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from keypose.tracker.keypoints.blazepose import Seen
from keypose.tracker.keypoints.region import Region
from keypose.tracker.storage import pace


@pytest.fixture(autouse=True)
def _own_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))


class Counting:
    """A network that only counts its inference passes."""

    fingerprint = "counting"
    passes = 0

    def infer(self, picture: NDArray[np.uint8], region: Region) -> Seen:
        self.passes += 1
        assert region.is_within(*picture.shape[1::-1])
        return None  # type: ignore[return-value]


def test_what_was_measured_is_known_by_network() -> None:
    assert pace.seconds_a_frame("thunder") is None
    pace.keep_seconds_a_frame("thunder", 0.125)
    pace.keep_seconds_a_frame("full", 0.0625)
    assert pace.seconds_a_frame("thunder") == 0.125
    assert pace.known_or_measured("full") == 0.0625


@pytest.mark.parametrize("content", [b"", b"[]", b'{"thunder": "fast"}', b'{"thunder": -1}'])
def test_a_file_that_is_none_is_as_if_it_was_not_there(tmp_path: Path, content: bytes) -> None:
    folder = tmp_path / "keypose"
    folder.mkdir()
    (folder / "draft-pace.json").write_bytes(content)
    assert pace.seconds_a_frame("thunder") is None
    pace.keep_seconds_a_frame("thunder", 0.5)
    assert pace.seconds_a_frame("thunder") == 0.5


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), 1e9])
def test_a_time_that_cannot_be_is_not_kept(seconds: float) -> None:
    pace.keep_seconds_a_frame("thunder", seconds)
    assert pace.seconds_a_frame("thunder") is None


def test_a_few_looks_measure_it() -> None:
    network = Counting()
    assert pace.measured_seconds_a_frame(network) > 0
    assert network.passes == pace.PASSES
