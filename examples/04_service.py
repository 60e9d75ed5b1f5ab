"""Asks a running service for poses over HTTP: start one with `motionsplice serve BANK`, and name its address."""

import json
import sys
import urllib.parse
import urllib.request
from typing import Any

url = sys.argv[1] if len(sys.argv) > 1 else "http://127.0.0.1:8000"


def get(path: str, **parameters: str | float) -> dict[str, Any]:
    with urllib.request.urlopen(f"{url}{path}?{urllib.parse.urlencode(parameters)}") as answer:
        return json.load(answer)


skeleton = get("/v1/skeleton", axes="unity")
print(f"{len(skeleton['joints'])} joints, the first is {skeleton['joints'][0]!r}")
for time in (0.0, 0.5, 1.0):
    pose = get("/v1/pose", locomotion="walk", action="wave", time=time, axes="unity")
    print(f"{time:.1f} s: root at {pose['root_positions']}, {len(pose['rotations'])} rotations")
