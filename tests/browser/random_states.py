"""What comes by itself, from a seed: states of a job, of segments, messages, window sizes."""

from __future__ import annotations

import random
from typing import Any

from playwright.sync_api import Page, ViewportSize

from tests.browser.interaction import section

WIDTHS = (320, 1920)
HEIGHTS = (480, 1080)


class RandomStates:
    """States of a job, of segments and messages as the server would send them, from a seed."""

    def __init__(self, page: Page, seed: int) -> None:
        self.chance = random.Random(seed)
        self.segments: list[dict[str, Any]] = section(page, "segments")
        self.parts: list[str] = [part["name"] for part in section(page, "body")["parts"]]

    def case(self) -> dict[str, Any]:
        """What is there, which control is pressed, and what comes while it is."""
        before = self.next()
        before["ui"] |= self.place()
        return {"before": before, "after": self.next(), "share": self.chance.random()}

    def next(self) -> dict[str, Any]:
        pick = self.chance.choice
        sections = {
            "job": self._job(),
            "segments": [s | {"state": pick(STATES_OF_SEGMENTS)} for s in self.segments],
            "suggest": pick(SUGGESTIONS),
            "saved": pick(SAVED),
            "undo": {"undo": pick((None, "move left hand")), "redo": pick((None, "turn"))},
            "proposed_pins": pick(([], [], PROPOSED)),
            "space": pick(([], FOUND)),
            "draft": pick((None, None, DRAFTED)),
            "tabs": pick((1, 2, 12)),
        }
        ui = {
            "connected": pick((True, True, False)),
            "line": pick((None, None, "lost", "long")),
            "ended": pick((None, None, {**self._job(), "kind": pick(("good", "check", "lost"))})),
        }
        toasts = [pick(TOASTS) for _ in range(pick((0, 0, 1, 2)))]
        return {"sections": sections, "ui": ui, "toasts": toasts, "theme": pick(THEMES)}

    def place(self) -> dict[str, Any]:
        """Where one looks: which tab and tool, which views."""
        pick = self.chance.choice
        return {
            "tab": pick(("part", "body", "camera", "track")),
            "tool": pick(("select", "rotate", "size")),
            "layout": pick(("main", "main", "side", "quad")),
            "toasts": [],
        }

    def size(self) -> ViewportSize:
        between = self.chance.randint
        return {"width": between(*WIDTHS), "height": between(*HEIGHTS)}

    def _job(self) -> dict[str, Any]:
        pick = self.chance.choice
        return {
            "state": pick(("idle", "running", "running", "done", "failed")),
            "title": pick(
                ("Tracking 0–24", "Drafting 64 of 180", "Tracked 0–24, 24–48 and 2 more")
            ),
            "words": pick(("", "pass 2 of 3, frame 17", "2 good, 1 to check, 3 lost")),
            "percent": self.chance.randint(0, 100),
            "seconds_left": pick((None, 4, 120)),
            "kind": pick(("track", "fit", "draft")),
            "worst": pick((None, "good", "check", "lost")),
        }


TITLES = ("Tracking 0–24", "Drafting 64 of 180", "Tracked 0–24, 24–48 and 2 more")
STATES_OF_SEGMENTS = ("good", "check", "lost", "outdated", "none", "waiting", "tracking")
THEMES = ("dark", "light")
SAVED = (
    {"state": "saved", "at": 0, "words": ""},
    {"state": "saving", "at": 0, "words": ""},
    {"state": "failed", "at": 0, "words": "No space left on the disk that holds this session."},
    {"state": "readonly", "at": 0, "words": "Read only: open in another Keypose."},
)
SUGGESTIONS = (
    None,
    {
        "frame": 12,
        "title": "Add a keyframe at 12.",
        "detail": "Long interval.",
        "kind": "key",
    },
    {"frame": None, "title": "3 segments need tracking.", "detail": "0–24", "kind": "track"},
    {"frame": None, "title": "All good.", "detail": "Nothing is left to do.", "kind": "good"},
)
PROPOSED: list[dict[str, Any]] = [
    {
        "part": "left_foot", "label": "Left foot", "side": "L", "landmarks": [], "point_m": None,
        "first": 0, "last": 24, "floor": True,
    }
]  # fmt: skip
FOUND = [
    {
        "kind": "slides", "words": "Left foot slides 9 cm, 40–55", "part": "left_foot", "first": 40,
        "last": 55, "go": 47, "remedy": "pin",
    }
]  # fmt: skip
DRAFTED = {
    "latest": True, "first": 0, "last": 72, "drafted": 73, "missing": [],
    "proposals": [{"frame": 12, "reason": "hidden", "parts": ["Left hand"]}],
}  # fmt: skip
TOASTS = (
    {"kind": "good", "words": "Keyframe 24 deleted.", "button": {"label": "Undo", "send": {}}},
    {"kind": "check", "words": "The camera seems to move. Switch off Static camera in Track."},
    {"kind": "info", "words": "Frame 0 is already a keyframe."},
)
