"""What segments were tracked to, kept for a while: where a limb is set right, only that limb has to
be tracked anew."""

from __future__ import annotations

from collections import OrderedDict
from threading import Lock
from typing import TYPE_CHECKING, TypeAlias

from keypose.tracker.session.settings import Quality

if TYPE_CHECKING:
    from keypose.tracker.tracking.cycle import Outcome

Kind: TypeAlias = tuple[str, Quality, str]
"""What identifies an outcome: the segment's key without part keyframes, quality, all settings."""

MOST_FRAMES = 4000
"""Of all that is kept together; some 15 kB each."""


class KeptOutcomes:
    """Outcomes of segments as tracked, the latest ones; used by several threads."""

    def __init__(self) -> None:
        self._kept: OrderedDict[Kind, Outcome] = OrderedDict()
        self._lock = Lock()

    def get(self, kind: Kind) -> Outcome | None:
        """That of this kind; of a preview also a better one of the same segment, so that nothing
        but a limb is seen to change while it is corrected."""
        key, quality, _ = kind
        with self._lock:
            better = [k for k in self._kept if k[0] == key and k[1] != "preview"]
            if kind not in self._kept and quality == "preview" and better:
                kind = better[-1]
            found = self._kept.get(kind)
            if found is not None:
                self._kept.move_to_end(kind)
            return found

    def keep(self, kind: Kind, outcome: Outcome) -> None:
        with self._lock:
            self._kept[kind] = outcome
            frames = sum(len(one.trajectory) for one in self._kept.values())
            while frames > MOST_FRAMES and len(self._kept) > 1:
                _, oldest = self._kept.popitem(last=False)
                frames -= len(oldest.trajectory)
