"""What a change costs somebody new stays as low as it is."""

from __future__ import annotations

import pytest

from bench.house import ROWS, Tree

MOST = {
    "conversions camera – world": 90,
    "files that solve outside solver": 7,
    "robust weights outside solver": 0,
    "tables that word causes": 2,
    "holders of the known motion": 1,
    "files in circles of imports": 0,
    "variables with vague names": 130,
    "docstrings that begin: Return": 0,
    "constants without a word": 101,
    "constants that share a line": 2,
    "fmt: " + "skip": 11,
    "script lines over 120": 55,
    "calls that unpack what was packed": 18,
    "words of READMEs": 8360,
}
"""Places, as `python -m bench.house` counts them. Lower the number where you lower the count."""
LEAST_TESTS = 0.6
"""Lines of tests for a line of a package of the method."""


@pytest.fixture(scope="module")
def tree() -> Tree:
    return Tree.here()


@pytest.mark.parametrize(("row", "most"), MOST.items())
def test_what_a_newcomer_pays_does_not_grow(tree: Tree, row: str, most: int) -> None:
    assert ROWS[row](tree) <= most


@pytest.mark.parametrize("row", [row for row in ROWS if row.startswith("test lines a line")])
def test_packages_of_the_method_have_their_tests(tree: Tree, row: str) -> None:
    assert ROWS[row](tree) >= LEAST_TESTS
