from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from pythonosc.osc_bundle import OscBundle
from pythonosc.osc_message import OscMessage
from typer.testing import CliRunner

from motionsplice.cli import app, main
from motionsplice.runtime.bank import Bank

ROOT = Path(__file__).parents[3]


@pytest.fixture
def listeners() -> Iterator[tuple[socket.socket, socket.socket]]:
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as first,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as second,
    ):
        for one in (first, second):
            one.bind(("127.0.0.1", 0))
            one.settimeout(5.0)
        yield first, second


def port(listener: socket.socket) -> int:
    return int(listener.getsockname()[1])


def test_both_protocols_get_the_whole_clip(bank: Bank, listeners: tuple[socket.socket, socket.socket]) -> None:
    vmc, livelink = listeners
    arguments = ["send", str(bank.path), "--locomotion", "wave", "--rate", "10"]
    receivers = ["--vmc", f"127.0.0.1:{port(vmc)}", "--livelink", f"127.0.0.1:{port(livelink)}"]
    result = CliRunner().invoke(app, arguments + receivers)
    assert result.exit_code == 0, result.output
    frames, left_out = int(bank.clip("wave").duration * 10.0) + 1, result.output.count(", 0 left out") != 1
    assert f"127.0.0.1:{port(vmc)}: " in result.output
    assert "not sent" not in result.output
    found: list[OscMessage] = []
    while not found or found[-1].address != "/VMC/Ext/T" or found[-1].params[0] < (frames - 1) / 10.0 - 1e-6:
        found += list(OscBundle(vmc.recv(65536)))
    times = [one.params[0] for one in found if one.address == "/VMC/Ext/T"]
    assert len(times) == frames or left_out
    bones = [json.loads(livelink.recv(65536))["motionsplice"] for _ in times]
    assert {len(one) for one in bones} == {bank.skeleton.joint_count}
    ahead = [one[0]["Location"][0] for one in bones]
    assert ahead[-1] > ahead[0] + 100.0  # centimetres: it walks


def test_ctrl_c_ends_it_with_a_report(bank: Bank, listeners: tuple[socket.socket, socket.socket]) -> None:
    vmc, _ = listeners
    command = [sys.executable, "-m", "motionsplice", "send", str(bank.path), "--locomotion", "walk", "--action", "wave"]
    sending = subprocess.Popen(
        [*command, "--vmc", f"127.0.0.1:{port(vmc)}", "--loop"], cwd=ROOT, stdout=subprocess.PIPE, text=True,
        env={**os.environ, "COLUMNS": "200"},
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a test run in the background ignores it
    )  # fmt: skip
    vmc.settimeout(60.0)
    for _ in range(20):
        vmc.recv(65536)
    sending.send_signal(signal.SIGINT)
    printed, _ = sending.communicate(timeout=120.0)
    assert sending.returncode == 0
    assert f"Sending 'walk' with 'wave' to 127.0.0.1:{port(vmc)}, 60 frames per second" in printed
    assert "frames, " in printed
    assert "late by " in printed


def test_a_closed_port_does_not_end_it(bank: Bank, listeners: tuple[socket.socket, socket.socket]) -> None:
    address = f"127.0.0.1:{port(listeners[0])}"
    listeners[0].close()
    arguments = ["send", str(bank.path), "--locomotion", "wave", "--rate", "10", "--vmc", address]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0
    assert result.output.count(f"{address}: Connection refused. Does the receiver run? Sending goes on.") == 1
    assert "not sent: Connection refused" in result.output


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        (["--locomotion", "walk"], "no receiver is given. Add --vmc HOST:PORT or --livelink HOST:PORT"),
        (["--locomotion", "wlak", "--vmc", "127.0.0.1"], "the bank has no clip 'wlak'. Did you mean 'walk'"),
        (["--locomotion", "walk", "--action", "jump", "--vmc", "127.0.0.1"], "the bank has no clip 'jump'"),
        (["--locomotion", "walk", "--vmc", "127.0.0.1:0"], "--vmc 127.0.0.1:0: the port 0 is not from 1 to 65535"),
        (["--locomotion", "walk", "--livelink", "a b"], "--livelink a b: unknown host 'a b'"),
        (["--locomotion", "walk", "--vmc", "127.0.0.1", "--rate", "0"], "the rate is 0 frames per second"),
        (["--locomotion", "walk", "--vmc", "127.0.0.1", "--rate", "1e9"], "the rate is 1e+09 frames per second"),
    ],
)
def test_mistakes_are_one_sentence(
    bank: Bank, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], arguments: list[str], problem: str
) -> None:
    monkeypatch.setattr(sys, "argv", ["motionsplice", "send", str(bank.path), *arguments])
    with pytest.raises(SystemExit) as end:
        main()
    assert end.value.code == 1
    assert problem in capsys.readouterr().err
