from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.service.problems import RequestError
from motionsplice.service.wire.query import REQUIRED, Query, choice, integer, number, text

QUERY = Query(
    text("name", "the name", REQUIRED),
    number("time", "seconds", 1.5, least=0.0, most=10.0),
    integer("count", "how many", 3, least=1, most=100),
    choice("form", "the form", ("round", "square"), "round"),
)


def test_values_are_read_and_others_are_their_defaults() -> None:
    assert QUERY.read(b"name=a+b%2Fc&count=7") == {"name": "a b/c", "time": 1.5, "count": 7, "form": "round"}
    assert QUERY.read(b"form=square&time=0&name=") == {"name": "", "time": 0.0, "count": 3, "form": "square"}


@pytest.mark.parametrize(
    ("query", "words"),
    [
        (b"", "name: it is missing"),
        (b"time=1", "name: it is missing"),
        (b"name=a&name=b", "name: it is given twice"),
        (b"name=a&nme=b", "there is no parameter 'nme'. Did you mean 'name'"),
        (b"name=a&", "there is no parameter ''"),
        (b"name=a&time=nan", "time: it is nan, and should be from 0 to 10"),
        (b"name=a&time=inf", "time: it is inf"),
        (b"name=a&time=10.1", "time: it is 10.1, and should be from 0 to 10"),
        (b"name=a&time=soon", "time: "),
        (b"name=a&time=", "time: "),
        (b"name=a&count=0", "count: it is 0, and should be from 1 to 100"),
        (b"name=a&count=1.0", "count: it is '1.0', and should be a whole number, from 1 to 100"),
        (b"name=a&count=-1", "count: "),
        (b"name=a&count=" + b"9" * 5000, "count: "),
        (b"name=a&form=oval", "form: it is 'oval', and should be one of round, square"),
    ],
)
def test_what_is_wrong_is_named(query: bytes, words: str) -> None:
    with pytest.raises(RequestError) as caught:
        QUERY.read(query)
    assert words in str(caught.value)
    assert len(str(caught.value)) < 200


@given(st.binary(max_size=200) | st.from_regex(rb"(name|time|count|form)=[a-z0-9%&=+.-]{0,20}", fullmatch=True))
def test_any_bytes_are_read_or_refused(query: bytes) -> None:
    with suppress(RequestError):
        assert set(QUERY.read(query)) == {"name", "time", "count", "form"}
