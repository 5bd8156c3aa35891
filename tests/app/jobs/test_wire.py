"""Messages between the two processes."""

from __future__ import annotations

from multiprocessing import Pipe

import numpy as np
import pytest

from keypose.app.jobs.messages import JobFailed, PassFinished, SegmentFinished
from keypose.app.jobs.wire import receive, send
from keypose.tracker.body.trajectory import Pass
from keypose.tracker.tracking.result import SegmentResult
from tests.app.results_cases import session, track


def test_results_arrive_as_they_were_sent_and_cannot_be_written_to() -> None:
    here, there = Pipe()
    sent = SegmentFinished(3, track(session(), 0, 4))
    send(here, sent)
    got = receive(there)
    assert (got.job, got.result.key, got.result.verdict) == (
        3,
        sent.result.key,
        sent.result.verdict,
    )
    path = got.result.trajectory
    np.testing.assert_array_equal(path.Rs_parent_part, sent.result.trajectory.Rs_parent_part)
    measured = [rows for _, rows in got.result.diagnostics.arrays()]
    assert len(measured) == 4
    for array in (path.Rs_parent_part, path.ps_camera_root, *measured):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


def test_trajectories_on_the_way_cannot_be_written_to_either() -> None:
    here, there = Pipe()
    path = track(session(), 0, 4).trajectory
    send(here, PassFinished(1, 2, 6, SegmentResult.on_the_way(Pass("pass", path, 3.5), "k")))
    got = receive(there)
    assert got.words == "pass 3 of 6"
    assert got.result.span == (0, 4)
    assert not got.result.finished
    assert not got.result.trajectory.ps_camera_root.flags.writeable


def test_the_end_of_the_other_side_is_noticed() -> None:
    here, there = Pipe()
    send(here, JobFailed(1, "Over."))
    here.close()
    assert receive(there) == JobFailed(1, "Over.")
    with pytest.raises(EOFError):
        receive(there)
