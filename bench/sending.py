"""Measures what `motionsplice send` sends: `python -m bench.sending [--seconds 60] [--check]`.

A process receives VMC, JSON Live Link and a control on loopback. The control is a process that sends a few bytes and
sleeps until the next frame is due: it shows what the machine does to any program. --check exits with status 1 if a
figure misses its target.

packing     microseconds to pack a frame, median
datagrams   datagrams of a frame, and bytes of the largest
interval    milliseconds from frame to frame, as the process that receives them measures it
"""

from __future__ import annotations

import multiprocessing
import select
import socket
import tempfile
import time
from contextlib import closing
from multiprocessing.connection import Connection
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from bench.clips import bank_of
from bench.findings import Findings
from motionsplice.cli import run
from motionsplice.motion.procedural.hand_rig import with_fingers
from motionsplice.motion.procedural.library import make
from motionsplice.motion.quaternion import Floats
from motionsplice.motion.roles import find_roles
from motionsplice.runtime.bank import Bank
from motionsplice.sending.live_link import LiveLink
from motionsplice.sending.performance import perform
from motionsplice.sending.receiver import Receiver
from motionsplice.sending.schedule import Schedule
from motionsplice.sending.vmc import MOST, Vmc

STREAMS = ("VMC", "Live Link", "control")
Arrivals = list[tuple[float, int]]  # of each datagram: seconds, and bytes
CALLS = 3000
SILENCE = 1.0  # seconds without a datagram after which the receiver ends, once it is told


def packing(findings: Findings) -> None:
    """Packs built-in motions, without and with fingers."""
    body = make("walk", "wave", seconds=4.0)
    for clip in (body, with_fingers(body)):
        positions, rotations = clip.root_positions.astype(np.float32), clip.rotations.astype(np.float32)
        joints = clip.skeleton.joint_count
        for name, protocol in (("VMC", Vmc(clip, find_roles(clip.skeleton))), ("Live Link", LiveLink(clip.skeleton))):
            seconds, largest, count = np.empty(CALLS), 0, 0
            for call in range(CALLS):
                frame = call % clip.frame_count
                began = time.perf_counter()
                datagrams = protocol.datagrams(call / 60.0, positions[frame], rotations[frame])
                seconds[call] = time.perf_counter() - began
                largest, count = max(largest, *map(len, datagrams)), len(datagrams)
            label = f"{name}, {joints} joints"
            findings.add(f"{label}: packing, us", 1e6 * float(np.median(seconds)), "{:.0f}", most=250.0)
            findings.add(f"{label}: datagrams", count, "{:.0f}")
            most = float(MOST) if name == "VMC" else 9216.0
            findings.add(f"{label}: bytes of the largest", largest, "{:.0f}", most=most)


def stream(findings: Findings, bank: Bank, rate: float, seconds: float) -> None:
    """Sends one character by both protocols, and compares what arrives with what was sent."""
    vmc, link = Vmc(bank.motion("walk"), bank.roles), LiveLink(bank.skeleton)
    processes = multiprocessing.get_context("spawn")
    ours, theirs = processes.Pipe()
    listening = processes.Process(target=_listen, args=(theirs,))
    listening.start()
    addresses = [f"127.0.0.1:{port}" for port in ours.recv()]
    ready = processes.Event()
    control = processes.Process(target=_control, args=(ready, addresses[2], rate, seconds))
    control.start()
    ready.wait()
    schedule = Schedule(rate, seconds)
    with closing(Receiver(addresses[0], 0, "")) as to_vmc, closing(Receiver(addresses[1], 0, "")) as to_link:
        for frame in perform(bank, "walk", "wave", schedule):
            datagrams = vmc.datagrams(*frame)
            to_vmc.send(datagrams)
            to_link.send(link.datagrams(*frame))
        sent = {"VMC": to_vmc.sent, "Live Link": to_link.sent}
    control.join()
    ours.send("end")
    arrived: dict[str, Arrivals] = ours.recv()
    listening.join()
    findings.add("frames", schedule.made, "{:.0f}")
    findings.add("frames left out, late by a whole frame", schedule.left_out, "{:.0f}")
    findings.add("lateness, ms, mean", 1000.0 * schedule.late / schedule.made)
    for name, count in sent.items():
        findings.add(f"{name}: datagrams lost", count - len(arrived[name]), "{:.0f}", most=0.0)
    last = {"VMC": len(datagrams[-1])}  # bytes of the datagram that ends a frame
    for name in STREAMS:
        times = [at for at, size in arrived[name] if size == last.get(name, size)]
        for label, value in _intervals(np.array(times)).items():
            findings.add(f"{name}: interval, ms, {label}", value)


def _intervals(times: Floats) -> dict[str, float]:
    between = 1000.0 * np.diff(times)
    low, median, high = np.percentile(between, [1, 50, 99])
    return {"p1": low, "median": median, "p99": high, "largest": between.max()}


def _listen(pipe: Connection) -> None:
    """Receives until the pipe says that all was sent, and it is silent. Sends ports first, then arrivals by stream."""
    sockets = {name: socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for name in STREAMS}
    for one in sockets.values():
        one.bind(("127.0.0.1", 0))
    pipe.send([one.getsockname()[1] for one in sockets.values()])
    arrived: dict[str, Arrivals] = {name: [] for name in STREAMS}
    names = {one: name for name, one in sockets.items()}
    while True:
        ready, _, _ = select.select(names, [], [], SILENCE)
        for one in ready:
            size = len(one.recv(65536))
            arrived[names[one]].append((time.perf_counter(), size))
        if not ready and pipe.poll():
            break
    pipe.send(arrived)


def _control(ready: Event, address: str, rate: float, seconds: float) -> None:
    with closing(Receiver(address, 0, "")) as receiver:
        ready.set()
        for _ in Schedule(rate, seconds):
            receiver.send([b"control"])


def main(
    seconds: Annotated[float, typer.Option(help="How long to send.")] = 60.0,
    rate: Annotated[float, typer.Option(help="Frames per second.")] = 60.0,
    check: Annotated[bool, typer.Option(help="Exit with status 1 if a figure misses its target.")] = False,
) -> None:
    """Measures packing, and a stream on loopback."""
    findings = Findings(f"Sending, {rate:g} frames per second for {seconds:g} s")
    packing(findings)
    with tempfile.TemporaryDirectory() as folder:
        stream(findings, bank_of(None, "walk", Path(folder)), rate, seconds)
    findings.show()
    for sentence in findings.missed:
        print(sentence)
    if findings.missed and check:
        raise typer.Exit(1)


if __name__ == "__main__":
    run(lambda: typer.run(main))
