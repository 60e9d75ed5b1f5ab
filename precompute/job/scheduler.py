"""A cluster's workers, reached through the scheduler of Dask distributed (docs/cluster.md)."""

from __future__ import annotations

import socket
from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager

from motionsplice.motion.errors import SettingsError

PATIENCE = 10.0  # seconds that a scheduler may take to answer
RETRIES = 3


@contextmanager
def executor_of(address: str) -> Iterator[Executor]:
    """Connects to a scheduler, such as `tcp://10.0.0.5:8786`, and disconnects in the end.

    Tasks that have not begun are then given up. Raises SettingsError if Dask is not installed, or the scheduler does
    not answer within PATIENCE.
    """
    try:
        from distributed import Client
        from distributed.comm.addressing import get_address_host_port
    except ImportError:
        mend = "Run `pip install 'motionsplice[cluster]'`"
        raise SettingsError("a scheduler needs Dask, which is not installed", mend=mend) from None
    try:
        socket.create_connection(get_address_host_port(address), PATIENCE).close()  # a Client would go on trying
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        mend = "Start one with `dask scheduler`, and give its address as tcp://HOST:PORT"
        raise SettingsError(f"no scheduler answers: {error}", file=address, mend=mend) from None
    with client:
        yield client.get_executor(pure=False, retries=RETRIES)
