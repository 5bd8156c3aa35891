"""Edits that can be told apart afterwards, and of which each would show if it were made twice."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import Page

from keypose.tracker.storage.files import load_session

_MARK = """
async (numbers) => {
  const { send } = await window.keypose.module('store/link.js');
  for (const n of numbers) {
    send({ do: 'add_mask', polygon: [[n, 0], [n + 1, 0], [n, 1]], first: 0, last: 1 });
  }
}
"""

_WAITING = """
async () => {
  const { backlog } = await window.keypose.module('store/edits.js');
  return backlog() + window.keypose.ui.unsent.reduce((sum, { count }) => sum + count, 0);
}
"""


def mark(page: Page, *numbers: int) -> None:
    """One edit for each number."""
    page.evaluate(_MARK, list(numbers))


def waiting(page: Page) -> int:
    """How many edits the server has not confirmed."""
    return int(page.evaluate(_WAITING))


def marks(session: Path) -> list[int]:
    """Those that are on the disk, in their order."""
    masks = load_session(session).view.ignore_masks
    return [round(mask.polygon[0][0]) for mask in masks]
