"""What a film's file does not say, or says wrongly, of how it was taken."""

from __future__ import annotations

from pathlib import Path

from keypose.app.store.store import Store
from tests.app.document.test_edit_log import with_store
from tests.tracker.video_cases import numbered_picture, write_image


def test_numbers_that_are_missing_among_images_are_told_when_these_are_opened(
    tmp_path: Path,
) -> None:
    folder = tmp_path / "films" / "shots"
    folder.mkdir(parents=True)
    for number in (1, 2, 5):
        write_image(folder / f"{number}.png", numbered_picture(number))

    async def look(store: Store) -> None:
        message = (await store.join().next())[0]
        assert "numbers 3–4 missing" in message["words"]

    for _ in ("new", "again"):
        with_store(folder, look)
