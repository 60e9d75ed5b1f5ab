from __future__ import annotations

import re
from inspect import getdoc
from pathlib import Path
from textwrap import dedent

import pytest

from motionsplice.runtime.bank import Bank
from motionsplice.runtime.character import Characters
from motionsplice.runtime.evaluator import Evaluator
from motionsplice.runtime.requests import Requests


@pytest.mark.parametrize("kind", [Bank, Characters, Evaluator, Requests])
def test_the_example_in_a_docstring_runs(
    kind: type, bank: Bank, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = re.search(r"```python\n(.*?)```", getdoc(kind) or "", re.DOTALL)
    assert found is not None
    (tmp_path / "demo").mkdir()
    (tmp_path / "demo" / "bank").symlink_to(bank.path)
    monkeypatch.chdir(tmp_path)
    exec(compile(dedent(found[1]), kind.__name__, "exec"), {})
