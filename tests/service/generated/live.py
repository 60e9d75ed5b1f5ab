"""What the generated clients must know of the live service."""

from __future__ import annotations

import json
import urllib.request
from typing import Any

from tests.service.running import Running

TOKEN = "open sesame"


def operations(service: Running) -> dict[str, str]:
    """Returns the method and path of each operation in the schema, by name."""
    with urllib.request.urlopen(f"{service.url}/openapi.json") as answer:
        paths: dict[str, Any] = json.load(answer)["paths"]
    return {
        operation["operationId"]: f"{method.upper()} {path}"
        for path, methods in paths.items()
        for method, operation in methods.items()
    }
