"""A Keypose without a page that edits until it is killed, and says what was acknowledged.

python -m tests.app.scribe SESSION SEED   prints "opened MARK", then a line for each edit once it is
acknowledged: its number and the mark of the document then.
"""

from __future__ import annotations

import asyncio
import random
import sys
from pathlib import Path
from typing import Any

from keypose.app.document.library import Library
from keypose.app.store.store import Store
from keypose.tracker.storage.edit_history import mark_of

TRACKED = 0.3
"""So many of the runs are tracked meanwhile."""


def edit(random: random.Random, keys: tuple[int, ...], number: int) -> dict[str, Any]:
    """Something a person does."""
    angle = round(random.uniform(-40, 40), 3)
    part = random.choice(("left_forearm", "right_thigh", "head"))
    kind = random.randrange(8)
    if kind == 0 and number > 3:
        return {"do": random.choice(("undo", "redo", "undo"))}
    if kind == 1:
        return {"do": "go", "frame": random.choice(keys)}
    if kind == 2:
        return {"do": "add_key", "frame": random.randrange(0, 72)}
    if kind == 3 and len(keys) > 3:
        return {"do": "delete_key", "frame": random.choice(keys[1:-1])}
    if kind == 4:
        return {"do": "settings", "quality": random.choice(("full", "preview"))}
    if kind == 5:
        return {"do": "height", "cm": random.randint(150, 200)}
    return {"do": "angles", "part": part, "x": angle}


async def write(path: Path, seed: int) -> None:
    chance = random.Random(seed)
    loop = asyncio.get_running_loop()
    folder = path.parent.parent
    store = Store(loop, lambda *_: None, Library(folder / "work", [folder]))
    await store.open(path)
    tab = store.join()
    edits = store.app_state.edit
    assert edits is not None
    print("opened", mark_of(edits.settled), flush=True)
    if chance.random() < TRACKED:
        store.receive(tab, {"do": "track", "what": "all"})
    number = 0
    while True:
        number += 1
        assert store.app_state.edit is not None
        store.receive(tab, {**edit(chance, store.app_state.edit.keys, number), "n": number})
        mark = mark_of(store.app_state.edit.settled)
        acknowledged = 0
        while acknowledged < number:
            for message in await tab.next():
                acknowledged = max(acknowledged, message.get("ack", 0))
        print(number, mark, flush=True)
        if chance.random() < 0.3:
            await asyncio.sleep(chance.random() * 0.03)


if __name__ == "__main__":
    asyncio.run(write(Path(sys.argv[1]), int(sys.argv[2])))
