from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import threading
from pathlib import Path

from motionsplice.precompute.job.alone import LOCK, WAITING, alone_in
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank

HOLD = """
import sys, time
from pathlib import Path
from motionsplice.precompute.job.alone import alone_in

with alone_in(Path(sys.argv[1]), lambda *at: None):
    print("held", flush=True)
    time.sleep(600)
"""


def test_a_second_job_waits_for_the_first(tmp_path: Path) -> None:
    told, entered = list[tuple[str, int, int]](), threading.Event()

    def second() -> None:
        with alone_in(tmp_path, lambda *at: told.append(at)):
            entered.set()

    with alone_in(tmp_path, lambda *at: told.append(at)):
        thread = threading.Thread(target=second)
        thread.start()
        assert not entered.wait(0.3)
        assert told == [(WAITING, 0, 1)]
    thread.join()
    assert entered.is_set()
    assert told == [(WAITING, 0, 1), (WAITING, 1, 1)]


def test_a_killed_job_holds_nothing(tmp_path: Path) -> None:
    environment = {**os.environ, "PYTHONPATH": str(Path(__file__).parents[3])}
    command = [sys.executable, "-c", HOLD, str(tmp_path)]
    with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == b"held\n"
        holder.send_signal(signal.SIGKILL)
    told = list[tuple[str, int, int]]()
    with alone_in(tmp_path, lambda *at: told.append(at)):
        assert (tmp_path / LOCK).exists()
    assert not told


def test_two_jobs_for_one_folder_leave_a_whole_bank(clip_folder: Path, tmp_path: Path) -> None:
    """One reads more clips than the other, so each removes what the other one writes."""
    few = tmp_path / "few"
    few.mkdir()
    for name in ("walk", "run"):
        shutil.copy(clip_folder / f"{name}.bvh", few)
    out, digests = tmp_path / "bank", dict[str, str]()

    def build(folder: Path) -> None:
        digests[folder.name] = build_bank([folder], out, baseline="walk").digest

    threads = [threading.Thread(target=build, args=(folder,)) for folder in (clip_folder, few)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(digests) == 2
    assert Bank.open(out).digest in digests.values()
