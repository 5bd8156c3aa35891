"""Figures of the network that comes with the package, on what its training has not seen."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from bench.lift.films import HEAD, Film, compared, taken
from bench.lift.poses import KINDS, own_motions
from bench.lift.windows import Batch, Capture, How, Motions, batch, held_out, of_reference
from keypose.tracker.geometry.rotations import Array
from keypose.tracker.keypoints.lifting import both_ways, lifted

ROWS = 1500
NOMINAL = np.linspace(0.1, 0.9, 9)


def measure(capture: Path | None, films: list[tuple[Path, Path]]) -> None:
    """Print all tables for which there is material; films: of each the folder of its clip, and that
    of a session with its keypoints."""
    if capture is not None:
        print("Windows of motion that was left out; mm of a person of each one's size")
        print(f"{'':30}{'up':8} mean across along  inside 1 σ   ECE")
        for name, motions in left_out(capture).items():
            for up in (1.0, 0.0):
                _of_windows(name, motions, up)
    for clip, session in films:
        read = Film.read if (clip / "mocap.json").is_file() else Film.of_person
        film = read(session, clip)
        print(f"\n{clip.name}: {film.kept.sum()} frames")
        print(HEAD)
        print(compared("BlazePose's depth", film.of_network(), film.truth))
        for label, up in (("lifted, up known", film.up), ("lifted", None)):
            size = film.size_m()
            found = lifted(film.keypoints, film.camera, film.times_s, up)
            p, sigma = taken(found.p_hips) * size, taken(found.sigma) * size
            print(compared(label, p[film.kept], film.truth, sigma[film.kept]))


def left_out(path: Path) -> dict[str, Motions]:
    """Motions by subject or kind, of what is left out of the training, and of our own."""
    data = Capture.read(path)
    names = list(zip(data.subjects, data.clips, strict=True))
    held = [held_out(*each) for each in names]

    def label(subject: str, clip: str) -> str:
        if clip.startswith("test_"):
            return f"{subject.removeprefix('cmu8_').removesuffix('_extra')}, test"
        return {"cmu_02": "subject 02", "acrnn_martial": "acrobatics, martial arts"}[subject]

    labels = [label(*each) if out else "" for each, out in zip(names, held, strict=True)]
    found = {
        each: data.motions([other == each for other in labels])
        for each in sorted(set(labels) - {""})
    }
    for kind in KINDS:
        joints, starts, kinds = own_motions(8 * len(KINDS), np.random.default_rng(7))
        weights = np.array([each == kind for each in kinds], float)
        local = of_reference(joints - joints[:, :1], starts)
        found[f"own: {kind}"] = Motions.of(local, joints[:, 0], starts, weights)
    return found


MEASURED = How(mixed_arms=0, mixed_legs=0, any_camera=0, alone=0, up_off_rad=0.03, children=0.05)


def drawn(motions: Motions, up_known: float, rows: int = ROWS, seed: int = 5) -> Batch:
    """Windows as they are measured."""
    how = replace(MEASURED, up_known=up_known)
    return batch([(motions, rows)], np.random.default_rng(seed), how)


def _of_windows(name: str, motions: Motions, up_known: float) -> None:
    windows = drawn(motions, up_known)
    p, sigma = both_ways(windows.points, windows.shown, windows.up)
    off = p - windows.joints
    mm = off * windows.size_m[:, None, None] * 1e3
    mean = np.linalg.norm(mm, axis=2).mean()
    across = np.sqrt((mm[..., :2] ** 2).sum(-1).mean())
    along = np.sqrt((mm[..., 2] ** 2).mean())
    share = np.abs(off) / sigma[..., [0, 0, 1]]
    share = share[:, 1:]
    inside = (share[..., :2] < 1).mean(), (share[..., 2] < 1).mean()
    print(
        f"{name:30}{'known' if up_known else 'unknown':8} {mean:4.0f} {across:6.0f} {along:5.0f}"
        f"   {inside[0]:4.0%} {inside[1]:4.0%}  {_ece(share):.3f}"
    )


def _ece(share: Array) -> float:
    """Mean of how far the share of errors within each of nine quantiles of Laplace's distribution
    is from what it is called."""
    bounds = -np.log(1 - NOMINAL) / np.sqrt(2)
    return float(
        np.mean([abs((share < bound).mean() - q) for bound, q in zip(bounds, NOMINAL, strict=True)])
    )
