"""Messages between the two processes."""

from __future__ import annotations

from multiprocessing import Pipe

import numpy as np
import pytest

from keypose.app.jobs.job import Failed, Progress
from keypose.app.jobs.wire import receive, send
from keypose.tracker.body.trajectory import Pass
from keypose.tracker.tracking.result import SegmentResult
from tests.app.jobs.job_cases import segment_done
from tests.app.results_cases import session, track


def test_results_arrive_as_they_were_sent_and_cannot_be_written_to() -> None:
    here, there = Pipe()
    sent = track(session(), 0, 4)
    send(here, segment_done(3, sent))
    report = receive(there)
    got = report.partial.found.result
    assert (report.job, got.key, got.verdict) == (3, sent.key, sent.verdict)
    path = got.trajectory
    np.testing.assert_array_equal(path.Rs_parent_part, sent.trajectory.Rs_parent_part)
    measured = [rows for _, rows in got.diagnostics.arrays()]
    assert len(measured) == 4
    for array in (path.Rs_parent_part, path.ps_camera_root, *measured):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


def test_trajectories_on_the_way_cannot_be_written_to_either() -> None:
    here, there = Pipe()
    path = track(session(), 0, 4).trajectory
    send(here, Progress(1, 0.5, partial=SegmentResult.on_the_way(Pass("pass", path, 3.5), "k")))
    got = receive(there).partial
    assert got.span == (0, 4)
    assert not got.finished
    assert not got.trajectory.ps_camera_root.flags.writeable


def test_the_end_of_the_other_side_is_noticed() -> None:
    here, there = Pipe()
    send(here, Failed(1, "Over."))
    here.close()
    assert receive(there) == Failed(1, "Over.")
    with pytest.raises(EOFError):
        receive(there)
