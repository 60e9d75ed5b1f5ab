"""The job on a cluster of Dask, on this machine."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from motionsplice.cli import app
from motionsplice.motion.errors import SettingsError
from motionsplice.precompute.job.job import build_bank
from motionsplice.precompute.job.scheduler import executor_of
from tests.conftest import CLIPS
from tests.precompute.job.test_job import files_of, write

distributed = pytest.importorskip("distributed", reason="the extra motionsplice[cluster] is not installed")


@pytest.fixture(scope="module")
def cluster() -> Iterator[Any]:
    options = {"n_workers": 2, "threads_per_worker": 1, "processes": True, "dashboard_address": "127.0.0.1:0"}
    with distributed.LocalCluster(host="127.0.0.1", **options) as cluster:
        yield cluster


def test_a_cluster_makes_the_same_bank_though_a_worker_is_killed(cluster: Any, tmp_path: Path) -> None:
    clips = write(tmp_path / "clips", **{name: CLIPS[name] for name in ("walk", "run", "side_step")})
    (clips / "broken.bvh").write_bytes(b"HIERARCHY\nROOT")
    build_bank([clips], tmp_path / "bank", baseline="walk", jobs=1)
    steps: list[tuple[str, int, int]] = []

    def kill(stage: str, done: int, total: int) -> None:
        steps.append((stage, done, total))
        if (stage, done) == ("aligning", 1):
            os.kill(cluster.workers[0].pid, signal.SIGKILL)

    with executor_of(cluster.scheduler_address) as executor:
        outcome = build_bank([clips], tmp_path / "other", baseline="walk", executor=executor, progress=kill)
    assert list(outcome.failed) == ["broken"]
    assert steps == [("reading", 1, 1), *(("aligning", done, 4) for done in (1, 2, 3, 4))]
    assert files_of(tmp_path / "other") == files_of(tmp_path / "bank")


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:9", "127.0.0.1", "carrier://pigeon:1"])
def test_a_scheduler_that_does_not_answer_is_named(address: str) -> None:
    with pytest.raises(SettingsError, match=f"^{address}: no scheduler answers: .* Start one with `dask scheduler`"):
        executor_of(address).__enter__()


def test_the_command_names_a_scheduler_that_does_not_answer(tmp_path: Path) -> None:
    write(tmp_path / "clips", walk=CLIPS["walk"])
    command = [
        "precompute",
        str(tmp_path / "clips"),
        "--out",
        str(tmp_path / "bank"),
        "--scheduler",
        "tcp://127.0.0.1:9",
    ]
    done = CliRunner().invoke(app, command)
    assert isinstance(done.exception, SettingsError)
    assert not (tmp_path / "bank").exists()
