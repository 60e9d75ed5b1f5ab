"""The OpenAPI document: FastAPI's part, and the direct route's, generated from the lists that check its queries."""

from __future__ import annotations

from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi

from motionsplice import __version__
from motionsplice.motion.axes import AXES
from motionsplice.runtime.bank import Bank
from motionsplice.service.admission import OPEN
from motionsplice.service.characters.hub import CHARACTERS
from motionsplice.service.models import BankInfo, ClipInfo, ServerInfo, SkeletonInfo
from motionsplice.service.openapi.direct import direct_operations, parameters
from motionsplice.service.openapi.schemas import SCHEMAS, with_named_enumerations
from motionsplice.service.routes import problem_response
from motionsplice.service.shared import Shared
from motionsplice.service.wire.messages import JSON

ABOUT = """Splices the upper body of any clip onto the lower body of any other.

Right-handed, Y up, characters face Z; metres, seconds, unit quaternions xyzw. `axes` selects another engine's axes and
units. Rotations are in the parent's frame, the root's in the world. Everything that depends only on the bank is also
available below `/v1/banks/{digest}`, where caches may keep it for ever; `If-None-Match` may be answered with 304.
`docs/protocol.md` describes the bytes.

`/v1/characters` is a WebSocket, which OpenAPI cannot describe: commands are JSON text, frames are MessagePack or JSON.
Its query:

"""
SERVERS = [{"url": "."}]  # relative to the document, which a proxy may serve below a path of its own
OTHERS = problem_response("default", "Any other error, such as a missing token")


def document(app: FastAPI, shared: Shared) -> dict[str, Any]:
    """Returns the document. Its examples are requests that the served bank can answer."""
    if app.openapi_schema is None:
        about = ABOUT + _websocket_query()
        schema = get_openapi(
            title=app.title, version=__version__, description=about, routes=app.routes, servers=SERVERS
        )
        paths = schema["paths"] | direct_operations(*_examples(shared.serving.bank))
        _fill_in(paths, shared)
        for operations in paths.values():
            for operation in operations.values():
                operation["responses"] |= OTHERS
        if shared.settings.token is not None:
            schema["components"]["securitySchemes"] = {"token": {"type": "http", "scheme": "bearer"}}
            for path, operations in paths.items():
                for operation in operations.values():
                    operation["security"] = [] if path in OPEN else [{"token": []}]
        models = schema["components"]["schemas"]
        schema["paths"] = with_named_enumerations(dict(sorted(paths.items())))
        schema["components"]["schemas"] = with_named_enumerations(models) | SCHEMAS
        app.openapi_schema = schema
    return app.openapi_schema


def _websocket_query() -> str:
    """Returns a Markdown list of the parameters of the WebSocket."""
    lines = []
    for one in parameters(CHARACTERS):
        values = ", ".join(f"`{value}`" for value in one["schema"].get("enum", ()))
        lines.append(f"- `{one['name']}`: {one['description']}" + (f": {values}" if values else ""))
    return "\n".join(lines)


def _fill_in(paths: dict[str, Any], shared: Shared) -> None:
    """Adds examples from the served bank to the parameters and answers."""
    bank = shared.serving.bank
    locomotion, action = _clips(bank)
    examples = {"name": locomotion, "locomotion": locomotion, "action": action, "time": 0.5, "count": 10, "rate": 30}
    for path, operations in paths.items():
        for parameter in operations.get("get", {}).get("parameters", []):
            if (name := parameter["name"]) in examples:
                parameter["example"] = "postures" if path == "/v1/tables/{name}" else examples[name]
    clip = ClipInfo.of(bank, bank.clip(locomotion))
    for path, answer in (
        ("/v1/server", ServerInfo.of(bank, shared.settings, ready=True)),
        ("/v1/bank", BankInfo.of(bank)),
        ("/v1/skeleton", SkeletonInfo.of(bank, AXES["gltf"])),
        ("/v1/clips/{name}", clip),
    ):
        _answer(paths, path)["example"] = answer.model_dump()
    _answer(paths, "/v1/clips")["example"] = [clip.model_dump()]


def _answer(paths: dict[str, Any], path: str) -> dict[str, Any]:
    content: dict[str, Any] = paths[path]["get"]["responses"]["200"]["content"][JSON]
    return content


def _clips(bank: Bank) -> tuple[str, str]:
    first = {clip.kind: clip.name for clip in reversed(bank.clips)}
    return first.get("locomotion", bank.clips[0].name), first.get("action", bank.clips[0].name)


def _examples(bank: Bank) -> tuple[dict[str, Any], dict[str, Any]]:
    """Returns a batch of poses and a take."""
    locomotion, action = _clips(bank)
    batch = {"clips": [locomotion, action], "locomotion": [0, 0], "time": [0.5, 1.0], "action": [1, -1]}
    commands = [{"do": "create", "locomotion": locomotion}, {"at": 30, "do": "act", "action": action}]
    return batch, {"rate": 60.0, "frames": 90, "commands": commands}
