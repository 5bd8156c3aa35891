"""The newest order counts."""

from __future__ import annotations

from keypose.app.jobs.job import Job
from keypose.app.jobs.worker import LatestOrder, Order

JOB = Job()


def order(job: int) -> Order:
    return Order(job, JOB)


def test_an_order_is_taken_up_and_goes_on_until_stopped() -> None:
    latest = LatestOrder()
    assert latest.put(order(1)) is None
    taken, cancelled = latest.take()
    assert taken.job == 1
    assert not cancelled.is_set()


def test_a_newer_order_cancels_the_one_at_work() -> None:
    latest = LatestOrder()
    latest.put(order(1))
    _, cancelled = latest.take()
    assert latest.put(order(2)) is None
    assert cancelled.is_set()
    taken, again = latest.take()
    assert taken.job == 2
    assert not again.is_set()


def test_a_newer_order_takes_the_place_of_the_one_that_waits() -> None:
    latest = LatestOrder()
    latest.put(order(1))
    assert latest.put(order(2)) == order(1)
    assert latest.take()[0].job == 2


def test_a_job_is_cancelled_where_it_is() -> None:
    latest = LatestOrder()
    latest.put(order(1))
    assert latest.cancel(1) == order(1)
    latest.put(order(2))
    _, cancelled = latest.take()
    assert latest.cancel(1) is None
    assert not cancelled.is_set()
    assert latest.cancel(2) is None
    assert cancelled.is_set()
