"""A clip whose work kills the process, in a whole job. The processes import this module, so it imports little."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest

from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import make
from motionsplice.precompute.job import job
from motionsplice.precompute.job.clip_work import Preparation
from motionsplice.precompute.job.job import build_bank
from motionsplice.precompute.job.readings import Identified
from motionsplice.precompute.job.workers import WorkerDiedError
from motionsplice.runtime.bank import Bank


class Deadly(Preparation):
    """Kills the process that prepares the clip `run`."""

    def run(self, one: Identified) -> None:
        if one.source.name == "run":
            os.kill(os.getpid(), signal.SIGKILL)
        super().run(one)


def test_a_clip_that_kills_its_process_is_named_and_the_bank_has_the_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(job, "WORTH_A_PROCESS", 1)
    monkeypatch.setattr(job, "Preparation", Deadly)
    for name in ("walk", "run"):
        (tmp_path / f"{name}.bvh").write_bytes(dump_bvh(make(name, seconds=2.0)))
    outcome = build_bank([tmp_path], tmp_path / "bank", baseline="walk", jobs=2)
    assert str(outcome.failed["run"]).startswith(f"{tmp_path / 'run.bvh'}, clip 'run': its worker process was killed")
    assert isinstance(outcome.failed["run"], WorkerDiedError)
    assert [clip.name for clip in Bank.open(tmp_path / "bank").clips] == ["walk"]
