"""The service against its schema: no request that fits it, or nearly fits it, makes the service fail."""

from __future__ import annotations

import json
from typing import Any

import pytest
import schemathesis
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from schemathesis import GenerationMode
from schemathesis.core.result import Ok

from tests.service.running import Running

FITTING = st.sampled_from(
    [
        {"locomotion": "walk", "action": "counting", "hands": "other_hands"},
        {"locomotion": "run", "hands": "counting_hands"},
        {"locomotion": "run", "action": "wave", "hands": "counting_hands"},
    ]
)


@pytest.fixture(scope="module")
def operations(hands_service: Running) -> list[Any]:
    schema = schemathesis.openapi.from_url(f"{hands_service.url}/openapi.json")
    return [found.ok() for found in schema.get_all_operations() if isinstance(found, Ok)]


@given(data=st.data())
@settings(max_examples=300, suppress_health_check=list(HealthCheck))
def test_no_request_makes_the_service_fail(operations: list[Any], data: st.DataObject) -> None:
    operation = data.draw(st.sampled_from(operations), label="operation")
    mode = data.draw(st.sampled_from(list(GenerationMode)), label="mode")
    case = data.draw(operation.as_strategy(generation_mode=mode), label="case")
    if "locomotion" in (case.query or {}) and data.draw(st.booleans(), label="fitting"):
        case.query |= data.draw(FITTING, label="clips")  # random names hardly ever fit
    answer = case.call()
    assert answer.status_code < 500, answer.content
    if answer.status_code >= 400:
        assert answer.headers["content-type"] == ["application/problem+json"]
        document = json.loads(answer.content)
        assert document["status"] == answer.status_code
        assert document["detail"]
