"""The network as JAX trains it: a layer, residual blocks, and one to joints and their scales."""

from __future__ import annotations

from functools import partial
from typing import Any, TypeAlias

import jax
import jax.numpy as jnp
import numpy as np

from keypose.tracker.keypoints.lifting import INPUTS, LIFTED, MIDDLE, OUTPUTS, POINTS

Weights: TypeAlias = dict[str, Any]
WIDTH = 512
BLOCKS = 2
_SEEN_NOW = slice(MIDDLE * len(POINTS) * 2, (MIDDLE + 1) * len(POINTS) * 2)
_SHOULDERS = [POINTS.index("right_shoulder"), POINTS.index("left_shoulder")]


def initial(seed: int, width: int = WIDTH, blocks: int = BLOCKS) -> Weights:
    """Weights before training."""
    rng = np.random.default_rng(seed)

    def layer(rows: int, columns: int, scale: float = 1.0) -> Any:
        return jnp.array(rng.normal(size=(rows, columns)) * np.sqrt(2 / rows) * scale, jnp.float32)

    weights = {
        "w0": layer(INPUTS, width),
        "b0": jnp.zeros(width),
        "wo": layer(width, OUTPUTS, 0.1),
        "bo": jnp.zeros(OUTPUTS),
    }
    for n in range(blocks):
        weights |= {
            f"w{n}a": layer(width, width),
            f"b{n}a": jnp.zeros(width),
            f"w{n}b": layer(width, width, 0.3),
            f"b{n}b": jnp.zeros(width),
        }
    return weights


def outputs(weights: Weights, x: Any) -> Any:
    """The outputs (B, 81) of inputs (B, 410)."""
    relu = jax.nn.relu
    h = relu(x @ weights["w0"] + weights["b0"])
    for n in range(sum(name[2:] == "a" for name in weights if name[0] == "w")):
        inner = relu(h @ weights[f"w{n}a"] + weights[f"b{n}a"])
        h = h + relu(inner @ weights[f"w{n}b"] + weights[f"b{n}b"])
    return h @ weights["wo"] + weights["bo"]


def answer(weights: Weights, x: Any) -> tuple[Any, Any]:
    """Joints (B, 16, 3) in body sizes, and the logarithm of Laplace's scales (B, 16, 2), as
    `keypose.tracker.keypoints.lifting.decoded` has them."""
    q = outputs(weights, x)
    each = q[:, :-1].reshape(-1, len(LIFTED), 5)
    seen = x[:, _SEEN_NOW].reshape(-1, len(POINTS), 2)
    neck = seen[:, _SHOULDERS].mean(axis=1, keepdims=True)
    scale = 0.38 * jnp.exp(jnp.clip(q[:, -1:, None], -2, 2))
    across = jnp.concatenate([seen, neck], axis=1) * scale + each[..., :2]
    p = jnp.concatenate([across, each[..., 2:3]], -1)
    return p, jnp.clip(each[..., 3:], -6, 1) - 2.5


def loss(weights: Weights, x: Any, y: Any, apart: Any) -> Any:
    """Laplace's likelihood, and the absolute error.

    apart: (B,) 1 of windows from which the network learns how far it is off alone, not where joints
    are: on motion that it has seen it is off by less.
    """
    p, log_b = answer(weights, x)
    scales = jnp.stack([log_b[..., 0], log_b[..., 0], log_b[..., 1]], -1)
    seen = 1.0 - apart[:, None, None]
    fixed = jax.lax.stop_gradient
    any_apart = apart.sum() > 0
    error = jnp.abs(p - y)
    share = jnp.where(any_apart, apart[:, None, None] * len(apart) / apart.sum(), 1.0)
    said = (share * (fixed(error) * jnp.exp(-scales) + scales)).mean()
    error = error * seen
    return said + (error * fixed(jnp.exp(-scales))).mean() + 2 * error.mean()


@partial(jax.jit, donate_argnums=(0, 1, 2))
def step(
    weights: Weights,
    mean: Weights,
    square: Weights,
    x: Any,
    y: Any,
    apart: Any,
    count: Any,
    rate: Any,
) -> tuple[Weights, Weights, Weights, Any]:
    """One step of Adam with decay of weights."""
    value, gradient = jax.value_and_grad(loss)(weights, x, y, apart)
    norm = jnp.sqrt(sum(jnp.sum(g * g) for g in jax.tree.leaves(gradient)))
    gradient = jax.tree.map(lambda g: g * jnp.minimum(1.0, 1.0 / norm), gradient)
    mean = jax.tree.map(lambda m, g: 0.9 * m + 0.1 * g, mean, gradient)
    square = jax.tree.map(lambda s, g: 0.995 * s + 0.005 * g * g, square, gradient)
    m_scale, s_scale = 1 / (1 - 0.9**count), 1 / (1 - 0.995**count)
    weights = jax.tree.map(
        lambda w, m, s: w - rate * (m * m_scale / (jnp.sqrt(s * s_scale) + 1e-8) + 1e-3 * w),
        weights,
        mean,
        square,
    )
    return weights, mean, square, value
