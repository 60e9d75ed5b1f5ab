"""Packers of the frames of a bank's rig, one for each kind of receiver."""

from __future__ import annotations

from motionsplice.runtime.bank import Bank
from motionsplice.sending.live_link import SUBJECT, LiveLink
from motionsplice.sending.receiver import Kind
from motionsplice.sending.vmc import Vmc

Packer = Vmc | LiveLink


def packer(kind: Kind, bank: Bank, subject: str = SUBJECT) -> Packer:
    """Returns a packer, which takes a few milliseconds. VMC has no names of subjects."""
    if kind == "vmc":
        return Vmc(bank.motion(bank.baseline.clip), bank.roles)
    return LiveLink(bank.skeleton, subject)
