from __future__ import annotations

import json
import shutil
from collections.abc import Iterator
from pathlib import Path

import msgpack
import numpy as np
import pytest
from pydantic import SecretStr

from motionsplice.runtime.bank import Bank
from motionsplice.service.settings import Settings
from tests.characters import character_file
from tests.reports import report_of
from tests.service.generated.live import TOKEN
from tests.service.running import Running, running


@pytest.fixture(scope="module")
def full_service(clip_folder: Path, bank: Bank, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    """A running service that answers every operation: it has a token, accepts clips, and has a report."""
    folder = tmp_path_factory.mktemp("service")
    shutil.copytree(clip_folder, folder / "clips")
    shutil.copytree(bank.path, folder / "bank")
    (folder / "scores.json").write_text(json.dumps(report_of(bank)))
    settings = Settings(token=SecretStr(TOKEN), clips=folder / "clips", report=folder / "scores.json")
    with running(folder / "bank", settings) as service:
        yield service


@pytest.fixture
def folder(tmp_path: Path, clip_folder: Path, bank: Bank) -> Path:
    """A folder with what the clients send."""
    shutil.copy(clip_folder / "wave.bvh", tmp_path)
    columns = {"locomotion": np.array([0, 0], "<i4"), "action": np.array([1, -1], "<i4"), "time": np.full(2, 0.5)}
    batch = {"clips": ["walk", "wave"], "posture": "absolute"} | {key: one.tobytes() for key, one in columns.items()}
    (tmp_path / "batch.msgpack").write_bytes(msgpack.packb(batch))
    (tmp_path / "hero.glb").write_bytes(character_file(bank.skeleton, seed=1))
    return tmp_path
