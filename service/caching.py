"""Which answers can be cached, for how long, and which of them a client already has."""

from __future__ import annotations

from starlette.types import Scope, Send

from motionsplice import __version__
from motionsplice.service.answers.answer import Headers

CACHED = frozenset({"/v1/splice", "/v1/expectation", "/v1/bank", "/v1/skeleton", "/v1/clips", "/v1/manifest"})
CACHED_BELOW = ("/v1/clips/", "/v1/tables/")
POSE = "/v1/pose"


class Unchanged(Exception):  # noqa: N818  # ends an answer of FastAPI, and is no error
    """The client has this answer already."""


def is_cacheable(path: str) -> bool:
    """Returns whether answers depend only on the bank, and are tagged also below a path without its digest."""
    return path in CACHED or path.startswith(CACHED_BELOW)


def always_succeeds(scope: Scope) -> bool:
    """Returns whether a request that FastAPI answers has nothing that could be refused."""
    return scope["path"] in CACHED and not scope["query_string"]


def cache_headers(digest: str, scope: bytes, *, immutable: bool) -> Headers:
    """Returns the headers of a cacheable answer: its tag, and how long caches may keep it.

    Another version of the service may represent the same bank in another way, so it has other tags.

    Args:
        digest: Of the bank.
        scope: `public` or `private`.
        immutable: Whether the path has the digest.
    """
    keep = b"%s, max-age=31536000, immutable" % scope if immutable else b"no-cache"
    return [(b"etag", f'"{digest}-{__version__}"'.encode()), (b"cache-control", keep)]


def client_has(scope: Scope, cached: Headers) -> bool:
    """Returns whether the client's If-None-Match header lists the tag of an answer that can be cached."""
    if not cached:
        return False
    (_, tag), _ = cached
    for name, value in scope["headers"]:
        if name == b"if-none-match":
            return value.strip() == b"*" or tag in [one.strip().removeprefix(b"W/") for one in value.split(b",")]
    return False


async def send_unchanged(send: Send, headers: Headers) -> int:
    """Answers 304, and returns this status."""
    await send({"type": "http.response.start", "status": 304, "headers": headers})
    await send({"type": "http.response.body", "body": b""})
    return 304
