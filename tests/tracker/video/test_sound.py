"""What two films sound like says when one was taken beside the other, or says nothing."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
import pytest

from keypose.tracker.films.sound import heard_s
from keypose.tracker.video.sound import loudness_of

RATE = 48_000
BEGINS_S = 1.37


def claps(seconds: float, seed: int = 1) -> np.ndarray:
    """Steps, claps and a ball, at moments and as loud as chance has it."""
    rng = np.random.default_rng(seed)
    sound = np.zeros(int(seconds * RATE))
    for at in rng.uniform(0, seconds - 0.2, int(1.6 * seconds)):
        length = int(0.06 * RATE)
        start = int(at * RATE)
        fading = np.exp(-np.linspace(0, 6, length)) * rng.uniform(0.1, 0.6)
        sound[start : start + length] += fading * rng.normal(0, 1, length)
    return sound


def write(path: Path, sound: np.ndarray | None, seconds: float, noise: int = 0) -> Path:
    """A film of grey pictures with a sound that a phone's microphone has its own noise in."""
    with av.open(path, "w") as file:
        pictures = file.add_stream("libx264", rate=30)
        pictures.width, pictures.height, pictures.pix_fmt = 64, 48, "yuv420p"
        track = None if sound is None else file.add_stream("aac", rate=RATE, layout="mono")
        for _ in range(int(30 * seconds)):
            grey = np.full((48, 64, 3), 90, np.uint8)
            file.mux(pictures.encode(av.VideoFrame.from_ndarray(grey, "rgb24")))
        file.mux(pictures.encode())
        if track is not None and sound is not None:
            own = 0.004 * np.random.default_rng(noise).normal(0, 1, len(sound))
            samples = np.clip(sound + own, -1, 1).astype(np.float32)
            for start in range(0, len(samples), 1024):
                block = av.AudioFrame.from_ndarray(
                    samples[None, start : start + 1024], "fltp", "mono"
                )
                block.sample_rate, block.pts = RATE, start
                block.time_base = Fraction(1, RATE)
                file.mux(track.encode(block))
            file.mux(track.encode())
    return path


def between(folder: Path, one: np.ndarray | None, other: np.ndarray | None) -> float | None:
    first = write(folder / "first.mp4", one, 8.0, noise=2)
    film = write(folder / "film.mp4", other, 5.0, noise=3)
    return heard_s(loudness_of(first), loudness_of(film))


def test_when_a_film_begins_is_heard_to_some_milliseconds(tmp_path: Path) -> None:
    sound = claps(8.0)
    later = 0.4 * sound[int(BEGINS_S * RATE) : int((BEGINS_S + 5.0) * RATE)]
    found = between(tmp_path, sound, later)
    assert found == pytest.approx(BEGINS_S, abs=0.03)


def test_a_film_that_began_before_the_first_is_heard_too(tmp_path: Path) -> None:
    sound = claps(12.0)
    found = between(tmp_path, sound[2 * RATE : 10 * RATE], sound[: 5 * RATE])
    assert found == pytest.approx(-2.0, abs=0.03)


@pytest.mark.parametrize("kind", ["none", "another event", "silence"])
def test_where_sound_says_nothing_no_offset_is_made_of_it(kind: str, tmp_path: Path) -> None:
    other = {"none": None, "another event": claps(5.0, seed=9), "silence": np.zeros(5 * RATE)}
    assert between(tmp_path, claps(8.0), other[kind]) is None


def test_an_even_beat_is_not_taken_for_an_offset(tmp_path: Path) -> None:
    beat = np.zeros(8 * RATE)
    for k in range(16):
        beat[k * RATE // 2 : k * RATE // 2 + 900] = 0.5 * np.random.default_rng(4).normal(0, 1, 900)
    assert between(tmp_path, beat, beat[RATE : 6 * RATE]) is None


def test_a_folder_of_pictures_has_no_sound(tmp_path: Path) -> None:
    assert loudness_of(tmp_path) is None
    (tmp_path / "text.mp4").write_text("no film")
    assert loudness_of(tmp_path / "text.mp4") is None
