from __future__ import annotations

from bench.findings import Findings
from bench.sending import stream
from motionsplice.runtime.bank import Bank


def test_a_stream_is_measured_from_end_to_end(bank: Bank) -> None:
    findings = Findings("sending")
    stream(findings, bank, rate=30.0, seconds=0.5)
    rows = {label: float(value) for label, value, _ in findings.rows}
    assert rows["frames"] + rows["frames left out, late by a whole frame"] == 16
    assert rows["VMC: datagrams lost"] == rows["Live Link: datagrams lost"] == 0
    for name in ("VMC", "Live Link", "control"):
        assert 10.0 < rows[f"{name}: interval, ms, median"] < 100.0
    assert not findings.missed
