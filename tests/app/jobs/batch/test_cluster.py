"""The same batch on a Dask cluster of this computer, one of whose workers is killed."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path
from threading import Event
from typing import Any

import pytest

from keypose.app.cli.main import main
from keypose.app.jobs.batch.cluster import ClusterPool
from keypose.app.jobs.batch.run_one import run_task
from keypose.app.jobs.batch.scheduler import TaskFinished, TaskStarted, run
from keypose.app.jobs.batch.task import Task
from keypose.tracker.errors import KeyposeError
from tests.app.jobs.batch.batch_cases import bytes_of, write_sessions
from tests.app.jobs.batch.dask_cases import cluster, holders, kill_at_work
from tests.app.serving import LONGEST_S

NAMES = ("a", "b", "c", "d")


def test_a_killed_worker_s_session_is_done_by_another_with_the_same_bytes(tmp_path: Path) -> None:
    paths, alone = (write_sessions(tmp_path / where, *NAMES) for where in ("many", "alone"))
    begun, ended = [], {}
    with cluster(tmp_path, 2) as (address, (victim, survivor)):
        pool = ClusterPool(address)
        try:
            for event in run([Task(path) for path in paths], pool, Event()):
                if isinstance(event, TaskStarted):
                    begun.append(event.number)
                    if event.number == 1:
                        kill_at_work(victim, paths)
                elif isinstance(event, TaskFinished):
                    ended[event.number] = event.summary.state
        finally:
            pool.close()
        assert set(holders(paths)) == {survivor}
    assert ended == dict.fromkeys(range(len(NAMES)), "tracked")
    for path in alone:
        run_task(Task(path), lambda step: None, Event())
    assert bytes_of(paths) == bytes_of(alone)


def test_the_command_works_on_a_cluster_and_one_that_goes_away_is_reported(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_sessions(tmp_path / "all", "a", "b")
    with cluster(tmp_path, 1) as (address, _):
        assert main(["batch", str(tmp_path / "all"), "--scheduler", address, "--json"]) == 0
        reported = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
        assert {s["state"] for s in reported[-1]["sessions"]} == {"tracked"}
        pool = ClusterPool(address)
    try:
        with pytest.raises(KeyposeError, match="is gone; what is finished is kept"):
            _go_on(pool)
    finally:
        pool.close()


def _go_on(pool: Any) -> None:
    """Use it until it notices."""
    end = time.monotonic() + LONGEST_S
    while time.monotonic() < end:
        pool.wait(0.1)
        pool.free_slots()


def test_where_dask_is_not_installed_one_sentence_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_sessions(tmp_path, "a")
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert main(["batch", str(tmp_path), "--scheduler", "127.0.0.1:1"]) == 2
    assert "pip install 'keypose[cluster]'" in capsys.readouterr().err


def test_a_scheduler_that_is_not_there_is_one_sentence(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_sessions(tmp_path, "a")
    assert main(["batch", str(tmp_path), "--scheduler", "127.0.0.1"]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert "The scheduler '127.0.0.1' cannot be reached" in err
