"""The service's copy of a bank at a URL."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from motionsplice.cli import app
from motionsplice.commands import serve
from motionsplice.commands.copied_bank import copied
from motionsplice.motion.errors import MotionError
from motionsplice.motion.storage.remote import Remote
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import Manifest
from motionsplice.service.exchange.copies import folder_for
from motionsplice.service.settings import Settings
from tests.conftest import CLIPS
from tests.precompute.job.test_job import files_of, write
from tests.s3 import bucket
from tests.service.running import eventually


def run(*words: str) -> str:
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    return done.output


def test_a_bank_is_built_on_s3_copied_served_and_followed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    served: list[tuple[Path, str]] = []

    def start(folder: Path, settings: Settings) -> None:
        served.append((folder, Bank.open(folder).digest))

    monkeypatch.setattr(serve, "start", start)
    clips = write(tmp_path / "clips", walk=CLIPS["walk"], run=CLIPS["run"])
    build_bank([clips], tmp_path / "bank")
    with bucket(monkeypatch) as url:
        place = Remote(f"{url}/bank")
        for file in clips.iterdir():
            (Remote(f"{url}/clips") / file.name).upload(file)
        command = ["precompute", f"{url}/clips", "--out", place.url, "--jobs", "1"]
        assert "2 clips, 0 reused" in run(*command)
        assert "nothing to do" in run(*command)
        run("serve", place.url, "--copies", str(tmp_path / "copies"))
        folder = folder_for(place.url, tmp_path / "copies")
        assert served == [(folder, Bank.open(tmp_path / "bank").digest)]
        assert files_of(folder) == files_of(tmp_path / "bank")
        with copied(place, folder, follow=True, interval=0.1):
            Remote(f"{url}/clips").remove(["run.bvh"])  # the baseline
            assert "1 clip, 0 reused" in run(*command)
            eventually(lambda: [clip.name for clip in Manifest.read(folder).clips] == ["walk"], 60.0)


def test_uploads_cannot_be_added_to_a_bank_at_a_url(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["serve", "s3://bucket/bank", "--clips", str(tmp_path)])
    assert isinstance(done.exception, MotionError)
    assert "uploaded clips cannot be added to a bank at a URL. Serve a folder" in str(done.exception)
