from __future__ import annotations

import asyncio

from motionsplice.service.turns import Turns


def test_each_turn_of_the_event_loop_has_one_piece_in_the_order_of_asking() -> None:
    done: list[tuple[int, str, int]] = []
    turn = 0

    async def client(name: str, turns: Turns) -> None:
        for piece in range(4):
            await turns.next()
            done.append((turn, name, piece))

    async def run() -> None:
        nonlocal turn
        turns = Turns()
        clients = [asyncio.create_task(client(name, turns)) for name in "abc"]
        while not all(one.done() for one in clients):
            await asyncio.sleep(0)
            turn += 1

    asyncio.run(run())
    assert [(name, piece) for _, name, piece in done] == [(name, piece) for piece in range(4) for name in "abc"]
    numbers = [number for number, _, _ in done]
    assert len(set(numbers)) == len(numbers)


def test_a_task_that_is_cancelled_holds_up_no_other() -> None:
    async def run() -> list[str]:
        turns, done = Turns(), list[str]()
        waiting = asyncio.create_task(turns.next())
        turns.call(lambda: done.append("next"))
        await asyncio.sleep(0)
        waiting.cancel()
        for _ in range(5):
            await asyncio.sleep(0)
        turns.call(lambda: done.append("later"))
        for _ in range(5):
            await asyncio.sleep(0)
        return done

    assert asyncio.run(run()) == ["next", "later"]
