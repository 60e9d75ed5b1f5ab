"""The service's copy of a bank at a URL."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from motionsplice.cli import app
from motionsplice.commands import serve
from motionsplice.commands.copied_bank import copied, folder_for
from motionsplice.motion.errors import MotionError
from motionsplice.motion.storage.remote import Remote
from motionsplice.precompute.job.install import publish_bank
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import Manifest
from motionsplice.service.settings import Settings
from tests.s3 import bucket
from tests.service.running import eventually


def quiet(stage: str, done: int, total: int) -> None:
    pass


def test_a_bank_at_a_url_is_copied_served_and_followed(
    bank: Bank, clip_folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    served: list[tuple[Path, str]] = []

    def start(folder: Path, settings: Settings) -> None:
        served.append((folder, Bank.open(folder).digest))

    monkeypatch.setattr(serve, "start", start)
    outcome = build_bank([clip_folder / "walk.bvh"], tmp_path / "other")
    with bucket(monkeypatch) as url:
        place = Remote(f"{url}/banks/hero")
        publish_bank(bank.path, place, quiet)
        done = CliRunner().invoke(app, ["serve", place.url, "--copies", str(tmp_path / "copies")])
        assert done.exit_code == 0, done.output
        folder = folder_for(place, tmp_path / "copies")
        assert served == [(folder, bank.digest)]
        with copied(place, folder, follow=True, interval=0.1):
            publish_bank(tmp_path / "other", place, quiet)
            eventually(lambda: Manifest.read(folder).digest == outcome.digest, 60.0)
    assert Bank.open(folder).digest == outcome.digest


def test_each_url_has_a_folder_of_its_own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first, second = (folder_for(Remote(f"s3://bucket/{name}"), None) for name in "ab")
    assert first != second
    assert first.parent == second.parent == tmp_path / "motionsplice" / "banks"


def test_uploads_cannot_be_added_to_a_bank_at_a_url(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["serve", "s3://bucket/bank", "--clips", str(tmp_path)])
    assert isinstance(done.exception, MotionError)
    assert "uploaded clips cannot be added to a bank at a URL. Serve a folder" in str(done.exception)
