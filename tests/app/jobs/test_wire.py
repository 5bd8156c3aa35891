"""Messages between the two processes."""

from __future__ import annotations

from multiprocessing import Pipe

import numpy as np
import pytest

from app.jobs.messages import JobFailed, PassFinished, SegmentFinished
from app.jobs.wire import receive, send
from tests.app.results_cases import session, track


def test_results_arrive_as_they_were_sent_and_cannot_be_written_to() -> None:
    here, there = Pipe()
    sent = SegmentFinished(3, track(session(), 0, 4))
    send(here, sent)
    got = receive(there)
    assert (got.job, got.track.key, got.track.verdict) == (3, sent.track.key, sent.track.verdict)
    path = got.track.trajectory
    np.testing.assert_array_equal(path.Rs_parent_part, sent.track.trajectory.Rs_parent_part)
    for array in (
        path.Rs_parent_part, path.ps_camera_root, got.track.rank, got.track.observability,
        got.track.residual, got.track.singular_values,
    ):  # fmt: skip
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 0


def test_trajectories_on_the_way_cannot_be_written_to_either() -> None:
    here, there = Pipe()
    path = track(session(), 0, 4).trajectory
    send(here, PassFinished(1, 0, 4, "k", "full", 2, 6, 3.5, path))
    got = receive(there)
    assert got.words == "pass 3 of 6"
    assert got.span == (0, 4)
    assert not got.track.finished
    assert not got.trajectory.ps_camera_root.flags.writeable


def test_the_end_of_the_other_side_is_noticed() -> None:
    here, there = Pipe()
    send(here, JobFailed(1, "Over."))
    here.close()
    assert receive(there) == JobFailed(1, "Over.")
    with pytest.raises(EOFError):
        receive(there)
