"""The client that openapi-python-client makes from the schema (`make generators`)."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from motionsplice.runtime.bank import Bank
from tests.service.generated.answers import check_answers
from tests.service.generated.live import TOKEN, operations
from tests.service.running import Running

ROOT = Path(__file__).parents[3]
CALLS = Path(__file__).with_name("calls.py")
PAGE = (ROOT / "docs" / "protocol.md").read_text()
PATH = f"{ROOT / '.venv-generators' / 'bin'}{os.pathsep}{os.environ['PATH']}"
GENERATOR = shutil.which("openapi-python-client", path=PATH)


@pytest.mark.skipif(GENERATOR is None, reason="openapi-python-client is not installed: make generators")
def test_every_operation_is_called_by_the_generated_client(full_service: Running, bank: Bank, folder: Path) -> None:
    assert GENERATOR is not None
    (settings,) = re.findall(r'```json\n({"content_type_overrides".*?)```', PAGE, re.DOTALL)
    (folder / "generator.json").write_text(settings)
    own = Path(GENERATOR).resolve().parent  # which also has Python, and ruff to format the client
    command = [GENERATOR, "generate", "--url", f"{full_service.url}/openapi.json", "--config", "generator.json"]
    command += ["--meta", "none", "--output-path", "motionsplice_client", "--fail-on-warning"]
    environment = {**os.environ, "PATH": f"{own}{os.pathsep}{os.environ['PATH']}"}
    made = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, timeout=120)
    assert (made.returncode, made.stderr, made.stdout) == (0, "", "Generating motionsplice_client\n")

    run = [str(own / "python"), str(CALLS), full_service.url, TOKEN, str(folder)]
    done = subprocess.run(run, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == sorted(operations(full_service))
    check_answers(folder, bank)
