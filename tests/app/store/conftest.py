"""A session for the store."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.scenes import sample


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return sample(tmp_path)
