"""The types that openapi-typescript makes from the schema, used by openapi-fetch in Node (`make generators`)."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import pytest

from motionsplice.runtime.bank import Bank
from tests.service.generated.answers import check_answers
from tests.service.generated.live import TOKEN, operations
from tests.service.running import Running

HERE = Path(__file__).parent
PACKAGES = HERE / "node_modules"
TYPED = ("--strict", "--target", "es2022", "--module", "nodenext", "--types", "node")


@pytest.mark.skipif(shutil.which("node") is None, reason="Node is not installed")
@pytest.mark.skipif(not PACKAGES.is_dir(), reason="openapi-typescript is not installed: make generators")
def test_every_operation_is_called_by_the_generated_types(full_service: Running, bank: Bank, folder: Path) -> None:
    for name in ("calls.ts", "package.json"):
        shutil.copy(HERE / name, folder)
    (folder / "node_modules").symlink_to(PACKAGES)
    made = run(folder, PACKAGES / ".bin/openapi-typescript", f"{full_service.url}/openapi.json", "-o", "schema.d.ts")
    assert "warn" not in made.lower()
    run(folder, PACKAGES / ".bin/tsc", *TYPED, "calls.ts")
    called = json.loads(run(folder, "node", "calls.js", full_service.url, TOKEN, folder).splitlines()[-1])
    assert called == sorted(operations(full_service).values())
    check_answers(folder, bank)


def run(folder: Path, *command: object) -> str:
    """Runs a command in a folder, and returns all that it prints."""
    done = subprocess.run([*map(str, command)], cwd=folder, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout + done.stderr
