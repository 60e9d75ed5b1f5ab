from __future__ import annotations

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from motionsplice.service.problems import RequestError
from motionsplice.service.wire.query import REQUIRED, Query, choice, integer, number, text

QUERY = Query(
    text("name", "name of a thing", REQUIRED),
    number("time", "seconds", 1.5, least=0.0, most=10.0),
    integer("count", "how many", 3, least=1, most=100),
    choice("form", "the form", ("round", "square"), "round"),
)


def test_values_are_parsed_and_missing_ones_have_defaults() -> None:
    assert QUERY.read(b"name=a+b%2Fc&count=7") == {"name": "a b/c", "time": 1.5, "count": 7, "form": "round"}
    assert QUERY.read(b"form=square&time=0&name=") == {"name": "", "time": 0.0, "count": 3, "form": "square"}


@pytest.mark.parametrize(
    ("query", "words"),
    [
        (b"", "name: missing. Give name, the name of a thing"),
        (b"time=1", "name: missing. Give name, the name of a thing"),
        (b"name=a&name=b", "name: given twice"),
        (b"name=a&nme=b", "unknown parameter 'nme'. Did you mean 'name'"),
        (b"name=a&", "unknown parameter ''"),
        (b"name=a&time=nan", "time: expected a number from 0 to 10, found 'nan'"),
        (b"name=a&time=inf", "time: expected a number from 0 to 10, found 'inf'"),
        (b"name=a&time=10.1", "time: expected a number from 0 to 10, found '10.1'"),
        (b"name=a&time=soon", "time: expected a number from 0 to 10, found 'soon'"),
        (b"name=a&time=", "time: expected a number from 0 to 10, found ''"),
        (b"name=a&count=0", "count: expected a whole number from 1 to 100, found '0'"),
        (b"name=a&count=1.0", "count: expected a whole number from 1 to 100, found '1.0'"),
        (b"name=a&count=-1", "count: "),
        (b"name=a&count=" + b"9" * 5000, "count: "),
        (b"name=a&form=oval", "form: expected one of round, square, found 'oval'"),
    ],
)
def test_an_error_names_the_parameter(query: bytes, words: str) -> None:
    with pytest.raises(RequestError) as caught:
        QUERY.read(query)
    assert words in str(caught.value)
    assert len(str(caught.value)) < 200


@given(st.binary(max_size=200) | st.from_regex(rb"(name|time|count|form)=[a-z0-9%&=+.-]{0,20}", fullmatch=True))
def test_any_bytes_are_read_or_refused(query: bytes) -> None:
    with suppress(RequestError):
        assert set(QUERY.read(query)) == {"name", "time", "count", "form"}
