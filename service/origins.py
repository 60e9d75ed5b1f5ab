"""Web origins and names of hosts as operators list them, in the form in which clients send them."""

from __future__ import annotations

import re
from ipaddress import ip_address

NAME = r"[\w-]+(?:\.[\w-]+)*"
ADDRESS = r"\[[\da-f:.]+\]"
ORIGIN = re.compile(rf"(?P<scheme>[a-z][a-z\d+.-]*)://(?P<host>{NAME}|{ADDRESS})(?::(?P<port>\d+))?/?", re.ASCII)
HOST = re.compile(rf"(?P<name>{NAME}|{ADDRESS})\.?(?::\d+)?", re.ASCII)
USUAL_PORTS = {"http": "80", "https": "443"}  # which browsers leave out of an origin


def listed_origin(text: str) -> str | None:
    """Returns a web origin as browsers send it, or None if it is none. `*` and `null` stay."""
    if text in ("*", "null"):
        return text
    if (found := ORIGIN.fullmatch(text.lower())) is None:
        return None
    scheme, host, port = found.group("scheme", "host", "port")
    return f"{scheme}://{host}" if port in (None, USUAL_PORTS.get(scheme)) else f"{scheme}://{host}:{port}"


def listed_host(text: str) -> str | None:
    """Returns the name or address of a host without its port, in lower case, or None if it is none. `*` stays."""
    if text == "*":
        return text
    try:
        return str(ip_address(text))
    except ValueError:
        found = HOST.fullmatch(text.lower())
    return found["name"].strip("[]") if found else None
