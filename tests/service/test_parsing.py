from __future__ import annotations

import gc
from contextlib import suppress
from typing import Any

import orjson
import pytest

from motionsplice.service.parsing import loads


@pytest.mark.parametrize("text", ["[" + "[]," * 20_000 + "1]", "[" + "[]," * 20_000])
def test_parsing_sets_off_no_collection_of_garbage_and_leaves_it_on(text: str) -> None:
    collections: list[Any] = []

    def note(phase: str, info: Any) -> None:
        collections.append((phase, info))

    def parse() -> int:
        with suppress(orjson.JSONDecodeError):
            loads(text)
        return len(collections)

    gc.collect()
    gc.callbacks.append(note)
    try:
        assert parse() <= 2  # one that begins afterwards, and its end
    finally:
        gc.callbacks.remove(note)
    assert gc.isenabled()


def test_it_stays_off_where_it_was_off() -> None:
    gc.disable()
    try:
        assert loads(b"[1]") == [1]
        assert not gc.isenabled()
    finally:
        gc.enable()
