"""Repeated frames of a film are said, and its session keeps them."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from keypose.app.cli.main import main
from keypose.app.document.new import new_session
from keypose.app.jobs.rerun import with_repeats
from keypose.tracker.video import Video
from tests.tracker.video_cases import write_clip

FRAMES = 30


def write_film(folder: Path, period: int) -> Path:
    """Noise, of which each frame of the period repeats the one before; none where it is 0."""
    noise = np.random.default_rng(0).integers(0, 255, (FRAMES, 48, 64, 3)).astype(np.uint8)
    shown = [noise[n - (period > 0 and n % period == period - 1)] for n in range(FRAMES)]
    return write_clip(folder / "film.mp4", shown)


def test_info_says_how_many_there_are(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    film = str(write_film(tmp_path, 6))
    assert main(["info", film, "--check"]) == 0
    assert "4 of 30 frames repeat the one before" in capsys.readouterr().out
    assert main(["info", film, "--check", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["repeated_frames"] == [5, 11, 17, 23]


@pytest.mark.parametrize(("period", "frames"), [(6, (5, 11, 17, 23)), (0, None)])
def test_a_session_to_be_tracked_knows_them(
    tmp_path: Path, period: int, frames: tuple[int, ...] | None
) -> None:
    with Video.open(write_film(tmp_path, period)) as video:
        begun = new_session(video, tmp_path / "session.json")
        session = with_repeats(begun, video, 0, FRAMES)
        found = session.view.video.repeats
        assert (found and found.frames) == frames
        assert with_repeats(session, video, 0, 1) is session
