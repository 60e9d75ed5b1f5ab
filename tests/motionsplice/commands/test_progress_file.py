from __future__ import annotations

import json
from pathlib import Path

import pytest

from motionsplice.commands.progress_file import ProgressFile
from motionsplice.motion.errors import SettingsError


def test_the_result_of_an_earlier_job_is_gone_at_once(tmp_path: Path) -> None:
    file = tmp_path / "progress.json"
    file.write_text('{"finished": true, "bank": "of yesterday", "failed": {}}')
    ProgressFile(file)
    assert json.loads(file.read_text()) == {"stage": "starting", "done": 0, "total": 0, "finished": False}


def test_a_file_that_cannot_be_written_is_named_before_the_job_begins(tmp_path: Path) -> None:
    for file in (tmp_path / "nowhere" / "progress.json", tmp_path):
        with pytest.raises(SettingsError, match=rf"^{file}: the progress cannot be written: .*Name a file"):
            ProgressFile(file)
    assert not list(tmp_path.parent.glob(f"{tmp_path.name}.*"))
