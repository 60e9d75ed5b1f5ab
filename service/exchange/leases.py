"""Keeps the mapped tables of a served bank when somebody truncates their files, as `cp` does that writes over them.

A process that reads a mapped page beyond the end of its file is killed. On Linux a process can lease a file: whoever
opens it for writing, or truncates it, waits until the lease is given back (for at most 45 s, `lease-break-time`). So
each table is leased, and copied into memory before its lease is given back. The copy takes the place of the mapped
pages at their address, so frames go on.

Only the owner of a file may lease it, and some file systems have no leases (NFS). A bank with such a table is mapped
from copies.
"""

from __future__ import annotations

import asyncio
import ctypes
import errno
import fcntl
import logging
import mmap
import os
import signal
import sys
import weakref
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionsplice.motion.errors import SettingsError
from motionsplice.runtime.bank import Bank
from motionsplice.service.background import in_background
from motionsplice.service.exchange.copies import folder_for, from_copies

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
    """The leases of all mapped tables of the banks that one process serves.

    Banks that cannot be leased are copied to a folder of their own in `copies`, or in the user's cache.
    """

    def __init__(self, copies: Path | None) -> None:
        self._copies = copies
        self._leases: list[_Lease] = []

    def hold(self, bank: Bank) -> Bank:
        """Returns the bank with its mapped tables leased or, if one cannot be leased, all mapped from copies.

        If they cannot be copied either, that is logged, and they stay mapped as they are. Raises BankError if a table
        that is copied was altered. May take seconds.
        """
        leases = []
        for name, table in bank.tables.items():
            if isinstance(table.base, np.memmap):
                try:
                    leases.append(_leased(bank, name))
                except OSError as error:
                    for lease in leases:
                        lease.give_back()
                    return self._from_copies(bank, f"{bank.files[name]} cannot be leased: {error.strerror}")
        self._leases += leases
        return bank

    def _from_copies(self, bank: Bank, reason: str) -> Bank:
        try:
            folder = folder_for(str(bank.path.absolute()), self._copies)
            if folder.parent.absolute() in bank.path.absolute().parents:
                raise SettingsError("the bank is a copy already", mend="Nothing but the service should write there")
            copy = from_copies(bank, folder)
        except (OSError, SettingsError) as error:
            detail = f"{reason}, and it cannot be copied: {error}"
            logger.warning("mapped tables are not protected from truncation", extra={"detail": detail})
            return bank
        logger.info("a bank is mapped from copies of its tables", extra={"detail": reason, "copies": str(folder)})
        return copy

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
    if sys.platform != "linux":
        raise OSError(errno.ENOSYS, "this system has no leases")
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
