"""Train the networks on one core."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from bench.lift.network import Weights, answer, initial, step
from bench.lift.windows import Capture, How, Motions, batch, held_out, own

ROWS = 256
"""Windows a step."""
OWN_CLIPS = 1500
RATE = 1e-3
EVERY = 1000
"""Steps between two looks at what is held out."""


@dataclass(frozen=True)
class Plan:
    """minutes: of all networks together.  seeds: of each one's first weights; windows are the
    same for all.  steps: in place of minutes.  folds: of so many a
    network learns from one how far it is off alone, each from another; 0: from all both."""

    minutes: float = 45.0
    seeds: tuple[int, ...] = (1, 2)
    how: How = field(default_factory=How)
    steps: int = 0
    folds: int = 8


def train(capture: Path, out: Path, plan: Plan, start: Path | None = None) -> None:
    """Train, and write weights and the curve as it goes."""
    data = Capture.read(capture)
    held = [held_out(*each) for each in zip(data.subjects, data.clips, strict=True)]
    seen = data.motions([not each for each in held])
    mine = round(plan.how.own_share * ROWS)
    sources = [(seen, ROWS - mine), (own(OWN_CLIPS, 100), mine)]
    sources = [each for each in sources if each[1]]
    looks = held_looks(data)
    nets = [initial(seed) for seed in plan.seeds] if start is None else load(start)
    states: list[tuple[Any, Any, Any]] = [
        (net, jax.tree.map(jnp.zeros_like, net), jax.tree.map(jnp.zeros_like, net)) for net in nets
    ]
    rng, began, count, losses = np.random.default_rng(1), time.time(), 0, 0.0
    sampling = 0.0
    while True:
        share = count / plan.steps if plan.steps else (time.time() - began) / (60 * plan.minutes)
        if share >= 1:
            break
        count += 1
        rate = RATE * min(1.0, count / 200) * (0.5 * (1 + np.cos(np.pi * share)) + 0.01)
        t = time.perf_counter()
        drawn = batch(sources, rng, plan.how)
        x, y = jnp.asarray(drawn.inputs), jnp.asarray(drawn.joints)
        sampling += time.perf_counter() - t
        values = []
        for n, state in enumerate(states):
            apart = drawn.clip % plan.folds == n if plan.folds else np.zeros(ROWS)
            asked = jnp.asarray(apart, jnp.float32)
            *new, value = step(*state, x, y, asked, float(count), rate)
            states[n] = (new[0], new[1], new[2])
            values.append(float(value))
        losses = 0.98 * losses + 0.02 * float(np.mean(values))
        if count % EVERY == 0 or count == 20:
            figures = "  ".join(f"{name} {_off(states, look)}" for name, look in looks.items())
            spent = f"{time.time() - began:.0f} s (windows {sampling:.0f})"
            print(f"step {count}  {spent}  loss {losses:.3f}  {figures}", flush=True)
            save(out, [state[0] for state in states])
    figures = "  ".join(f"{name} {_off(states, look)}" for name, look in looks.items())
    print(f"done: {count} steps  {time.time() - began:.0f} s  {figures}", flush=True)
    save(out, [state[0] for state in states])


def held_looks(data: Capture, rows: int = 1024) -> dict[str, Any]:
    """Windows of what is held out, by what it is."""
    kinds = {
        "subject 02": lambda s, c: s == "cmu_02",
        "martial arts": lambda s, c: s == "acrnn_martial",
        "eight actions": lambda s, c: c.startswith("test_"),
    }
    looks: dict[str, Any] = {}
    how = How(mixed_arms=0, mixed_legs=0, any_camera=0, alone=0, up_known=0.5, up_off_rad=0.03)
    sources: dict[str, Motions] = {
        name: data.motions([chosen(*each) for each in zip(data.subjects, data.clips, strict=True)])
        for name, chosen in kinds.items()
    }
    sources["own"] = own(64, 7)
    for name, motions in sources.items():
        looks[name] = batch([(motions, rows)], np.random.default_rng(7), how)
    return looks


_answer = jax.jit(answer)


def _off(states: list[tuple[Any, Any, Any]], look: Any) -> str:
    """Mean error and rms along the view, mm, of the mean of networks."""
    x = jnp.asarray(look.inputs)
    p = np.mean([np.asarray(_answer(state[0], x)[0]) for state in states], axis=0)
    off = (p - look.joints) * look.size_m[:, None, None] * 1e3
    known = look.inputs[:, -1] > 0
    each = np.linalg.norm(off, axis=2).mean(axis=1)
    along = np.sqrt((off[..., 2] ** 2).mean())
    by_up = f"up {each[known].mean():.1f} none {each[~known].mean():.1f}"
    return f"{each.mean():.1f} ({by_up} along {along:.1f})"


def save(path: Path, nets: list[Weights]) -> None:
    """Write the weights of networks."""
    arrays = {
        f"{n}.{key}": np.asarray(value) for n, net in enumerate(nets) for key, value in net.items()
    }
    np.savez(path, **arrays)


def load(path: Path) -> list[Weights]:
    """Weights of networks that were written."""
    with np.load(path) as file:
        count = 1 + max(int(key.split(".")[0]) for key in file)
        return [
            {key.split(".")[1]: jnp.asarray(file[key]) for key in file if key.startswith(f"{n}.")}
            for n in range(count)
        ]
