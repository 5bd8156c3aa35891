"""A slow tab gets the newest of everything, in few messages, and no answer is lost."""

from __future__ import annotations

import asyncio

from keypose.app.store.tabs import Tab


async def test_of_each_section_only_the_newest_value_is_sent() -> None:
    tab = Tab()
    for frame in range(500):
        tab.update({"view": frame})
        tab.acknowledge(frame)
    tab.update({"keys": [1]})
    messages = await tab.next()
    (state,) = messages
    assert state["set"] == {"view": 499, "keys": [1]}
    assert (state["done"], state["ack"]) == (0, 499)


async def test_answers_keep_their_order_and_come_before_the_state() -> None:
    tab = Tab()
    tab.update({"view": 1})
    for number in range(3):
        tab.send({"t": "reply", "id": number})
    messages = await tab.next()
    assert [message.get("id") for message in messages] == [0, 1, 2, None]


async def test_a_tab_without_news_waits_and_is_woken_by_an_acknowledgement() -> None:
    tab = Tab()
    tab.update({"view": 1})
    await tab.next()
    waiting = asyncio.ensure_future(tab.next())
    await asyncio.sleep(0)
    assert not waiting.done()
    tab.acknowledge(7)
    assert (await waiting)[0]["ack"] == 7


async def test_whose_messages_are_acknowledged_is_said_once() -> None:
    tab = Tab()
    tab.acknowledge(3, "one")
    tab.acknowledge(5, "one")
    tab.acknowledge(2, "two")
    first = await tab.next()
    tab.update({"view": 1})
    messages = [*first, *await tab.next()]
    assert messages[0]["acks"] == {"one": 5, "two": 2}
    assert messages[1]["acks"] == {}
