"""What the generators rely on in the schema."""

from __future__ import annotations

import json
import re

from fastapi.testclient import TestClient


def test_generators_find_names_and_types_in_the_schema(client: TestClient) -> None:
    document = client.get("/openapi.json").json()
    operations = [one for methods in document["paths"].values() for one in methods.values()]
    assert all("default" in one["responses"] for one in operations)
    assert all(re.fullmatch(r"(get|post)(_[a-z]+)+", one["operationId"]) for one in operations)
    assert "enum" not in json.dumps(document["paths"])
    schemas, numbers = document["components"]["schemas"], {"type": "number"}
    for name, leading in (("Pose", 0), ("Poses", 1), ("Frames", 1)):
        for key, inner in (("root_positions", 1), ("rotations", 2), ("world_positions", 2)):
            found = schemas[name]["properties"][key]
            for _ in range(leading + inner):
                found = found["items"]
            assert found == numbers
