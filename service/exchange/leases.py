"""Keeps the mapped tables of a served bank when somebody truncates their files, as `cp` does that writes over them.

A process that reads a mapped page beyond the end of its file is killed. On Linux a process can lease a file: whoever
opens it for writing, or truncates it, waits until the lease is given back (for at most 45 s, `lease-break-time`). So
each table is leased, and copied into memory before its lease is given back. The copy takes the place of the mapped
pages at their address, so frames go on.
"""

from __future__ import annotations

import asyncio
import ctypes
import fcntl
import logging
import mmap
import os
import signal
import sys
import weakref
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.runtime.bank import Bank
from motionsplice.service.exchange.background import in_background

logger = logging.getLogger(__name__)

INTERVAL = 0.5  # seconds between two checks
MREMAP_MAYMOVE, MREMAP_FIXED = 1, 2  # of linux/mman.h


@dataclass(frozen=True, eq=False)
class _Lease:
    bank: weakref.ref[Bank]
    table: str
    descriptor: int
    give_back: weakref.finalize[[int], Bank]  # also called when the bank is not used any more

    @property
    def is_wanted(self) -> bool:
        """Whether somebody waits to change the file."""
        return fcntl.fcntl(self.descriptor, fcntl.F_GETLEASE) != fcntl.F_RDLCK


class Leases:
    """The leases of all mapped tables of the banks that one process serves."""

    def __init__(self) -> None:
        self._leases: list[_Lease] = []

    def hold(self, bank: Bank) -> None:
        """Leases the files of a bank's mapped tables. What cannot be leased is logged, and stays mapped."""
        if sys.platform != "linux":
            return
        for name, table in bank.tables.items():
            if isinstance(table.base, np.memmap):
                try:
                    self._leases.append(_leased(bank, name))
                except OSError as error:
                    detail = f"{bank.files[name]}: {error.strerror}; only the owner of a file may lease it"
                    logger.warning("a mapped table is not protected from truncation", extra={"detail": detail})

    async def keep(self, interval: float = INTERVAL) -> None:
        """Copies tables whose files somebody is about to change. Runs until cancelled."""
        while True:
            for lease in tuple(self._leases):
                bank = lease.bank()
                if bank is None:
                    self._leases.remove(lease)
                elif lease.is_wanted and await _is_copied(bank, lease.table):
                    lease.give_back()
                    self._leases.remove(lease)
            await asyncio.sleep(interval)


async def _is_copied(bank: Bank, table: str) -> bool:
    file = bank.files[table]
    try:
        await in_background(partial(move_into_memory, bank.tables[table]))
    except OSError as error:
        detail = f"{file}: {error.strerror}"
        logger.error("a table that is served is overwritten and could not be kept", extra={"detail": detail})
        return False
    detail = f"{file}: kept in memory; replace banks by `motionsplice install`"
    logger.warning("a table that is served is overwritten", extra={"detail": detail})
    return True


def _leased(bank: Bank, table: str) -> _Lease:
    descriptor = os.open(bank.files[table], os.O_RDONLY | os.O_CLOEXEC)
    give_back = weakref.finalize(bank, os.close, descriptor)
    try:
        fcntl.fcntl(descriptor, fcntl.F_SETSIG, signal.SIGURG)  # is ignored; SIGIO, the default, would end the process
        fcntl.fcntl(descriptor, fcntl.F_SETLEASE, fcntl.F_RDLCK)
    except OSError:
        give_back()
        raise
    return _Lease(weakref.ref(bank), table, descriptor, give_back)


def move_into_memory(table: NDArray[Any]) -> None:
    """Replaces the pages of a mapped table by a copy, at the same address. Raises OSError, as when memory is short."""
    libc = ctypes.CDLL(None, use_errno=True)
    libc.mmap.restype = libc.mremap.restype = ctypes.c_void_p
    start = table.ctypes.data // mmap.PAGESIZE * mmap.PAGESIZE
    size = ctypes.c_size_t(table.ctypes.data + table.nbytes - start)
    writable = mmap.PROT_READ | mmap.PROT_WRITE
    copy = _checked(libc.mmap(None, size, writable, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, -1, ctypes.c_long(0)))
    ctypes.memmove(copy, start, size.value)
    _checked(libc.mprotect(ctypes.c_void_p(copy), size, mmap.PROT_READ))
    _checked(libc.mremap(
        ctypes.c_void_p(copy), size, size, MREMAP_MAYMOVE | MREMAP_FIXED, ctypes.c_void_p(start)
    ))  # fmt: skip


def _checked(result: int) -> int:
    if result in (-1, ctypes.c_void_p(-1).value):
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return result
