from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from fastapi.testclient import TestClient
from prometheus_client.parser import text_string_to_metric_families

EXCHANGED = """
from motionsplice.service.metrics import Metrics
metrics = Metrics()
for digest in ("first", "second", "first", "third"):
    metrics.serves(digest)
metrics.connections("http").set(0)
print(metrics.render()[0].decode())
"""


@pytest.mark.parametrize("several", [False, True], ids=["one process", "workers"])
def test_only_the_bank_that_is_served_is_shown(tmp_path: Path, several: bool) -> None:
    shared = {"PROMETHEUS_MULTIPROC_DIR": str(tmp_path)} if several else {}
    command = [sys.executable, "-W", "error", "-c", EXCHANGED]
    done = subprocess.run(command, env={**os.environ, **shared}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    lines = done.stdout.splitlines()
    assert [line for line in lines if line.startswith("motionsplice_bank_info")] == [
        'motionsplice_bank_info{digest="third"} 1.0'
    ]
    assert 'motionsplice_connections{kind="http"} 0.0' in lines  # other zeros stay


def test_metrics_are_in_the_format_that_all_collectors_know(client: TestClient) -> None:
    answer = client.get("/metrics")
    assert answer.headers["content-type"] == "text/plain; version=0.0.4; charset=utf-8"
    families = {one.name: one.type for one in text_string_to_metric_families(answer.text)}
    assert families["motionsplice_requests"] == "counter"
    assert all(name.startswith("motionsplice_") for name in families)
