"""The newest order counts."""

from __future__ import annotations

from app.jobs.desk import Desk
from app.jobs.reports import Order


def order(job: int) -> Order:
    return Order(job, b"", "", (), ("full",))


def test_an_order_is_taken_up_and_goes_on_until_told() -> None:
    desk = Desk()
    assert desk.put(order(1)) is None
    taken, cancelled = desk.take()
    assert taken.job == 1
    assert not cancelled.is_set()


def test_a_newer_order_cancels_the_one_at_work() -> None:
    desk = Desk()
    desk.put(order(1))
    _, cancelled = desk.take()
    assert desk.put(order(2)) is None
    assert cancelled.is_set()
    taken, again = desk.take()
    assert taken.job == 2
    assert not again.is_set()


def test_a_newer_order_takes_the_place_of_the_one_that_waits() -> None:
    desk = Desk()
    desk.put(order(1))
    assert desk.put(order(2)) == order(1)
    assert desk.take()[0].job == 2


def test_a_job_is_cancelled_where_it_is() -> None:
    desk = Desk()
    desk.put(order(1))
    assert desk.cancel(1) == order(1)
    desk.put(order(2))
    _, cancelled = desk.take()
    assert desk.cancel(1) is None
    assert not cancelled.is_set()
    assert desk.cancel(2) is None
    assert cancelled.is_set()
