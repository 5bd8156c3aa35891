"""A kernel weighs residuals by the slope of its loss: both lead least squares to one place."""

from __future__ import annotations

import numpy as np
import pytest

from keypose.tracker.solver.robust import (
    SQUARED,
    Cauchy,
    GemanMcClure,
    Huber,
    Kernel,
    Tukey,
)

KERNELS: dict[str, tuple[Kernel, list[float]]] = {
    "squared": (SQUARED, [1.0, 1.0, 1.0]),
    "Huber": (Huber(2.0), [1.0, 1.0, 0.2]),
    "Cauchy": (Cauchy(2.0), [1.0, 1 / 2, 1 / 26]),
    "Geman and McClure": (GemanMcClure(2.0), [1.0, 1 / 4, 1 / 26**2]),
    "Tukey": (Tukey(2.0), [1.0, 0.0, 0.0]),
}
"""Each with its weights at no distance, at its width of 2, and at five times that."""


@pytest.mark.parametrize("name", KERNELS)
def test_distances_weigh_what_the_kernel_of_that_name_says(name: str) -> None:
    kernel, weights = KERNELS[name]
    np.testing.assert_allclose(kernel.weight(np.array([0.0, 2.0, 10.0])), weights)


@pytest.mark.parametrize("name", KERNELS)
def test_the_weight_is_the_slope_of_the_loss_by_the_square(name: str) -> None:
    kernel = KERNELS[name][0]
    squares = np.array([0.01, 1.0, 3.9, 4.1, 25.0, 400.0])
    step = 1e-6 * squares
    rise = kernel.loss(np.sqrt(squares + step)) - kernel.loss(np.sqrt(squares - step))
    np.testing.assert_allclose(rise / (2 * step), kernel.weight(np.sqrt(squares)), atol=1e-6)
    assert kernel.loss(np.zeros(1)) == 0


@pytest.mark.parametrize("name", ["Cauchy", "Geman and McClure", "Tukey"])
def test_what_is_infinitely_far_has_no_weight(name: str) -> None:
    assert KERNELS[name][0].weight(np.array([np.inf])) == 0
