from __future__ import annotations

import re
from importlib.metadata import distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.hardening.third_party import EXTRAS, PACKAGE, licence, packages

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize(
    ("file", "name"), [("THIRD_PARTY.md", r"^\| ([\w.-]+) \|"), ("constraints.txt", r"^([\w.-]+)==")]
)
def test_what_is_required_is_listed(file: str, name: str) -> None:
    listed = {canonicalize_name(one) for one in re.findall(name, (ROOT / file).read_text(), re.MULTILINE)}
    required = [Requirement(line) for line in distribution(PACKAGE).requires or ()]
    shipped = [one for one in required if not one.marker or any(one.marker.evaluate({"extra": x}) for x in EXTRAS)]
    assert len(shipped) > 10
    assert {canonicalize_name(one.name) for one in shipped} <= listed


def test_licences_come_from_the_metadata() -> None:
    found = packages()
    assert licence(found["numpy"]).startswith("BSD")
    assert "starlette" in found  # FastAPI requires it
    assert not {"pytest", "atheris", "mkdocs"} & found.keys()
