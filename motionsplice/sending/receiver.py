"""A receiver of datagrams: its address, and the socket that sends to it."""

from __future__ import annotations

import re
import socket
from collections.abc import Mapping, Sequence
from typing import Literal

from motionsplice.motion.errors import SettingsError

Kind = Literal["vmc", "livelink"]
PORTS: Mapping[Kind, int] = {"vmc": 39539, "livelink": 54321}  # where receivers of a protocol listen by default

ADDRESS = re.compile(r"(\[(?P<six>[^\[\]]+)\]|(?P<host>[^:\[\]]+))(:(?P<port>[0-9]{1,5}))?")
HOST_AND_PORT = "Write HOST or HOST:PORT, such as 127.0.0.1:{port}"


class Receiver:
    """Sends datagrams to one address.

    Args:
        address: HOST or HOST:PORT; an IPv6 address stands in brackets.
        port: The port if the address has none.
        option: The option or variable that gave the address, for messages.

    Attributes:
        name: Host and port as the user may write them.
        sent: Number of datagrams sent.
        unsent: Number of datagrams that the system did not send, so far.
        reason: Why it did not send the last of these.

    Raises:
        SettingsError: The address is malformed, its host is unknown, or nothing can be sent to it.
    """

    def __init__(self, address: str, port: int, option: str) -> None:
        place = f"{option} {address}"
        host, port = host_and_port(address, port, place)
        self.name = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
        self.sent = self.unsent = 0
        self.reason = ""
        try:
            found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
        except (OSError, UnicodeError):
            raise SettingsError(f"unknown host {host!r}", place=place, mend=HOST_AND_PORT.format(port=port)) from None
        # IPv4 first: `localhost` is often ::1 too, where receivers seldom listen
        family, *_, where = min(found, key=lambda one: one[0] != socket.AF_INET)
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        self._socket.setblocking(False)
        try:
            self._socket.connect(where)  # so that the system reports a closed port
        except OSError as error:
            self._socket.close()
            problem = f"cannot send there: {error.strerror or error}"
            raise SettingsError(problem, place=place, mend="Name the address of one machine") from None

    def send(self, datagrams: Sequence[bytes | memoryview]) -> int:
        """Sends datagrams, without waiting. Returns how many the system refused.

        That is not an error: the receiver may start later, or come back.
        """
        before = self.unsent
        for datagram in datagrams:
            try:
                self._socket.send(datagram)
                self.sent += 1
            except OSError as error:
                self.unsent += 1
                self.reason = error.strerror or str(error)
        return self.unsent - before

    def close(self) -> None:
        """Closes the socket."""
        self._socket.close()


def host_and_port(address: str, port: int, place: str) -> tuple[str, int]:
    """Splits an address into host and port: `port` if it has none. Raises SettingsError, which names `place`."""
    mend = HOST_AND_PORT.format(port=port)
    if (found := ADDRESS.fullmatch(address)) is None:
        raise SettingsError("this is not an address", place=place, mend=mend)
    number = int(found["port"] or port)
    if not 0 < number < 65536:
        raise SettingsError(f"the port {number} is not from 1 to 65535", place=place, mend=mend)
    return found["six"] or found["host"], number
