"""What can rot: pages, lists and configuration that repeat what the code says."""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import motionsplice
from motionsplice.runtime.format.manifest import VERSION

ROOT = Path(__file__).parents[2]
BESIDE = ("motion", "precompute", "runtime", "service")  # an sdist has these folders in `motionsplice` only


def exists(path: str) -> bool:
    within = path.partition("/")[0] in BESIDE
    return (ROOT / path).exists() or (within and (ROOT / "motionsplice" / path).exists())


def public_names() -> list[str]:
    stub = ast.parse((ROOT / "motionsplice" / "__init__.pyi").read_text())
    return [name.asname or name.name for node in stub.body if isinstance(node, ast.ImportFrom) for name in node.names]


def test_every_public_name_is_in_the_api_reference_once() -> None:
    pages = "\n".join(page.read_text() for page in sorted((ROOT / "docs" / "api").glob("*.md")))
    assert sorted(re.findall(r"^::: motionsplice\.(\w+)$", pages, re.MULTILINE)) == sorted(public_names())


def test_every_page_is_in_the_navigation() -> None:
    navigation = (ROOT / "mkdocs.yml").read_text().partition("\nnav:\n")[2]
    pages = {page.relative_to(ROOT / "docs").as_posix() for page in (ROOT / "docs").rglob("*.md")}
    assert set(re.findall(r"[\w/]+\.md", navigation)) == pages


def test_the_changelog_has_this_version() -> None:
    headings = re.findall(r"^## (.+)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)
    assert any(motionsplice.__version__ in heading for heading in headings)


def test_the_changelog_has_the_current_formats() -> None:
    formats = (ROOT / "CHANGELOG.md").read_text().partition("## Bank formats")[2].partition("\n## ")[0]
    assert re.findall(r"^\| (\d+) \|", formats, re.MULTILINE) == [str(number) for number in range(VERSION, 0, -1)]


def test_files_that_contributing_names_exist() -> None:
    named = re.findall(r"`((?:[\w.*-]+/)+[\w.*-]*|[\w-]+\.(?:md|toml|py))`", (ROOT / "CONTRIBUTING.md").read_text())
    real = {name for name in named if "NAME" not in name and "*" not in name and name not in ("site/", "__main__.py")}
    folders = ("", "motionsplice/commands/")
    assert len(real) > 30
    assert not [name for name in sorted(real) if not any(exists(folder + name) for folder in folders)]


@pytest.mark.parametrize("package", [*BESIDE, "bench"])
def test_the_index_of_the_documentation_lists_every_subpackage(package: str) -> None:
    index = (ROOT / "docs" / "README.md").read_text(encoding="utf-8")
    table = index.partition(f"### Subpackages of `{package}`\n")[2].partition("\n### ")[0]
    inside = {file.parent.name for top in ("", "motionsplice") for file in (ROOT / top / package).glob("*/__init__.py")}
    assert set(re.findall(r"^\| `(\w+)` \|", table, re.MULTILINE)) == inside


def test_make_targets_that_contributing_names_exist() -> None:
    targets = set(re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    assert set(re.findall(r"`make ([\w-]+)", (ROOT / "CONTRIBUTING.md").read_text())) <= targets


def test_words_that_the_makefile_selects_tests_by_are_in_their_names() -> None:
    text = (ROOT / "Makefile").read_text().replace("\\\n", " ")
    for name, value in re.findall(r"^(\w+) = (.*)$", text, re.MULTILINE):
        text = text.replace(f"$({name})", value)
    text = re.sub(r"not \(\$\(subst.*\)\)\)", "", text)  # names of files
    selections = re.findall(r'pytest -q ([^"\n]*) -k "([^"]+)"', text)
    assert selections
    for files, words in selections:
        names = " ".join(re.findall(r"def (test_\w+)", "".join((ROOT / file).read_text() for file in files.split())))
        assert not [
            word for word in re.findall(r"\w+", words) if word not in names and word not in {"or", "and", "not"}
        ]


def test_modules_have_at_most_300_lines() -> None:
    modules = [file for folder in (*BESIDE, "motionsplice", "bench") for file in (ROOT / folder).rglob("*.py")]
    assert len(modules) > 100
    assert not [str(one) for one in modules if len(one.read_text(encoding="utf-8").splitlines()) > 300]


def test_a_checkout_without_links_says_what_to_do(tmp_path: Path) -> None:
    package = tmp_path / "motionsplice"
    package.mkdir()
    for name in ("__init__.py", "__init__.pyi"):
        shutil.copy(ROOT / "motionsplice" / name, package)
    (package / "runtime").write_text("../runtime")
    done = subprocess.run([sys.executable, "-c", "import motionsplice"], cwd=tmp_path, capture_output=True, text=True)
    assert "this checkout has no symbolic links" in done.stderr
    assert "git config core.symlinks true" in done.stderr
