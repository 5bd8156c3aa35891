"""How much a session may hold, checked before it is read, which could take minutes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

MOST: Mapping[str, int] = {
    "keyframes": 10_000,
    "part_keyframes": 10_000,
    "drafts": 10_000,
    "ignore_masks": 10_000,
    "camera_keyframes": 10_000,
    "keypoint_corrections": 10_000,
    "pins": 10_000,
    "bonds": 1_000,
    "notes": 1_000,
    "reviewed": 10_000,
    "ahead": 100,
}
"""Far above what a person sets in a session, and above what standing on the floor pins."""


def require_few(data: Mapping[str, Any]) -> None:
    """ValueError when a list is longer than a session may have; checked before any of it is read,
    which could take minutes."""
    for name, most in MOST.items():
        entries = data.get(name)
        if isinstance(entries, list | tuple) and len(entries) > most:
            raise ValueError(f"{name}: {len(entries)} are more than the {most} a session may have")


def few(data: Any) -> Any:
    """The same JSON; ValueError when a list in it is too long."""
    if isinstance(data, dict):
        require_few(data)
    return data
