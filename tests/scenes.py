"""What many tests begin with: a copy of a sample, and a store that has it open without a worker."""

from __future__ import annotations

import asyncio
import shutil
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any, ClassVar, TypeVar

from keypose.app.document.library import Library
from keypose.app.editor.state import EditorState
from keypose.app.jobs.job import Job, Report
from keypose.app.store.sections import Sections
from keypose.app.store.store import Store
from keypose.app.store.tabs import Tab

DeskT = TypeVar("DeskT", bound="StoreDesk")
SAMPLES = Path(__file__).parents[1] / "sample_videos"


def sample(folder: Path, name: str = "person") -> Path:
    """The session file of a copy of a sample, with all that belongs to it."""
    shutil.copytree(SAMPLES / name, folder / name)
    return folder / name / "session.json"


@asynccontextmanager
async def opened_store(path: Path, *, ends: bool = True) -> AsyncIterator[Store]:
    """A store with a session open; it ends well or, so to speak, not at all."""
    folder = path.parent.parent
    library = Library(folder / "work", [folder])
    store = Store(asyncio.get_running_loop(), lambda *_: None, library)
    await store.open(path)
    try:
        yield store
    finally:
        if ends:
            await store.stop()


Asked = TypeVar("Asked", bound=Job)


class IdleWorker:
    """Stands for the worker: takes orders, and says what the test says."""

    newest: ClassVar[Any]

    def __init__(self, report: Callable[[Report], None], _: object) -> None:
        self.report = report
        self.cancelled = 0
        self.jobs: list[Job] = []
        type(self).newest = self

    def start(self, job: Job) -> int:
        self.jobs.append(job)
        return len(self.jobs)

    def of(self, kind: type[Asked]) -> list[Asked]:
        """The jobs of a kind that were begun."""
        return [job for job in self.jobs if isinstance(job, kind)]

    def cancel(self) -> None:
        self.cancelled += 1

    def pause(self, on: bool) -> None: ...

    def close(self) -> None: ...


class StoreDesk:
    """A store with a tab that sends it messages."""

    def __init__(self, store: Store) -> None:
        self.store, self.tab = store, store.join()

    def do(self, *messages: dict[str, Any], tab: Tab | None = None) -> None:
        for message in messages:
            self.store.receive(tab or self.tab, message)

    @property
    def edit(self) -> EditorState:
        edit = self.store.app_state.edit
        assert edit is not None
        return edit

    @property
    def doc(self) -> Any:
        return self.edit.doc

    def section(self, name: str) -> Any:
        """What the tabs are told."""
        return Sections().changed(self.store.app_state.displayed)[name]


@asynccontextmanager
async def at_desk(path: Path, kind: type[DeskT]) -> AsyncIterator[DeskT]:
    """A desk of this kind at a store that has a session open."""
    async with opened_store(path) as store:
        yield kind(store)
