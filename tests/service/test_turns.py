from __future__ import annotations

import asyncio

import pytest

from motionsplice.service import turns as turns_module
from motionsplice.service.turns import AT_ONCE, Turns


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


async def _turns(count: int) -> None:
    for _ in range(count):
        await asyncio.sleep(0)


@pytest.fixture
def at_once_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """Lets no time be free for further pieces."""
    monkeypatch.setattr(turns_module, "SHARE", 0.0)
    monkeypatch.setattr(turns_module, "MOST_FREE", 1e6)


def test_no_piece_is_begun_right_before_a_frame() -> None:
    async def run() -> list[int]:
        turns, done, counts, now = Turns(), list[int](), list[int](), asyncio.get_running_loop().time()
        turns.next_tick(now)
        for piece in range(3):
            turns.call(lambda piece=piece: done.append(piece))  # type: ignore[misc]
        await _turns(10)
        counts.append(len(done))
        turns.ticked(now)
        await _turns(10)
        return [*counts, len(done)]

    assert asyncio.run(run()) == [0, 3]


@pytest.mark.usefixtures("at_once_only")
def test_a_few_pieces_are_begun_at_once_and_the_others_after_the_next_tick() -> None:
    async def run() -> list[int]:
        turns, done, counts, now = Turns(), list[int](), list[int](), asyncio.get_running_loop().time()
        turns.next_tick(now + 1e3)
        for piece in range(3 * AT_ONCE):
            turns.call(lambda piece=piece: done.append(piece))  # type: ignore[misc]
        for _ in range(4):
            await _turns(4 * AT_ONCE)
            counts.append(len(done))
            turns.ticked(now)
            turns.next_tick(now + 1e3)
        assert done == list(range(3 * AT_ONCE))
        return counts

    assert asyncio.run(run()) == [AT_ONCE, 2 * AT_ONCE, 3 * AT_ONCE, 3 * AT_ONCE]


@pytest.mark.usefixtures("at_once_only")
def test_the_first_pieces_after_an_idle_time_do_not_wait() -> None:
    async def run() -> int:
        turns, done = Turns(), list[int]()
        for piece in range(3 * AT_ONCE):
            turns.call(lambda piece=piece: done.append(piece))  # type: ignore[misc]
        await _turns(4 * AT_ONCE)
        assert len(done) == 3 * AT_ONCE
        turns.next_tick(asyncio.get_running_loop().time() + 1e3)
        for piece in range(3 * AT_ONCE):
            turns.call(lambda piece=piece: done.append(piece))  # type: ignore[misc]
        await _turns(4 * AT_ONCE)
        return len(done)

    assert asyncio.run(run()) == 4 * AT_ONCE


@pytest.mark.parametrize("due", [1e9, float("inf")])
def test_long_before_the_next_frame_no_piece_waits(due: float) -> None:
    async def run() -> int:
        turns, done = Turns(), list[int]()
        turns.next_tick(0.0)
        turns.ticked(0.0)
        for piece in range(10 * AT_ONCE):
            turns.call(lambda piece=piece: done.append(piece))  # type: ignore[misc]
        await _turns(4 * AT_ONCE)
        assert len(done) == AT_ONCE
        turns.next_tick(due)
        await _turns(20 * AT_ONCE)
        return len(done)

    assert asyncio.run(run()) == 10 * AT_ONCE
