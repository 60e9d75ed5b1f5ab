"""The wheel, installed in a fresh environment: what is in it, and that foreign packages do it no harm."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import venv
import zipfile
from pathlib import Path

import pytest

from motionsplice.runtime.bank import Bank

ROOT = Path(__file__).parents[2]
OURS = ("motion", "runtime", "precompute", "service")  # folders of the project that are not packages of their own
WITHOUT_PYTHONPATH = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "wheel", "--quiet", "--no-deps"]
    subprocess.run([*pip, "--no-build-isolation", "--wheel-dir", folder, ROOT], check=True, capture_output=True)
    (built,) = folder.glob("*.whl")
    return built


@pytest.fixture(scope="module")
def environment(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A fresh environment with the wheel and foreign packages of our folders' names; its dependencies are ours."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False)
    (site,) = folder.glob("lib/python*/site-packages")
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    write_foreign_packages(site)
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib"))
    return folder


def write_foreign_packages(folder: Path) -> None:
    for name in OURS:
        (folder / name).mkdir()
        (folder / name / "__init__.py").write_text(f"raise ImportError('the foreign {name} was imported')\n")


def run(environment: Path, folder: Path, *arguments: str | Path) -> str:
    command = [environment / "bin" / "python", *arguments]
    done = subprocess.run(command, cwd=folder, env=WITHOUT_PYTHONPATH, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_the_wheel_has_one_name_at_its_top(wheel: Path) -> None:
    names = zipfile.ZipFile(wheel).namelist()
    tops = {name.partition("/")[0] for name in names}
    assert {top for top in tops if not top.endswith(".dist-info")} == {"motionsplice"}
    for name in OURS:
        assert f"motionsplice/{name}/__init__.py" in names
    assert "motionsplice/py.typed" in names
    assert "motionsplice/__init__.pyi" in names
    viewer = {name.removeprefix("motionsplice/service/viewer/") for name in names if "/viewer/" in name}
    assert {"page/index.html", "page/main.js", "page/vendor/shared.js", "page/vendor/three.LICENSE"} <= viewer
    assert {name for name in viewer if not name.startswith("page/")} == {"__init__.py", "routes.py"}


def test_a_wheel_from_the_sdist_has_the_same_files(wheel: Path, tmp_path: Path) -> None:
    build = [sys.executable, "-m", "build", "--no-isolation", "--sdist", "--outdir", str(tmp_path), str(ROOT)]
    subprocess.run(build, check=True, capture_output=True)
    (sdist,) = tmp_path.glob("*.tar.gz")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "wheel", "--quiet", "--no-deps"]
    subprocess.run([*pip, "--no-build-isolation", "--wheel-dir", tmp_path, sdist], check=True, capture_output=True)
    (again,) = tmp_path.glob("*.whl")
    assert sorted(zipfile.ZipFile(again).namelist()) == sorted(zipfile.ZipFile(wheel).namelist())


def test_installed_packages_of_our_folders_names_do_no_harm(environment: Path, tmp_path: Path, bank: Bank) -> None:
    shown = run(
        environment, tmp_path, "-c", "import motionsplice; print(motionsplice.__file__, motionsplice.Evaluator)"
    )
    assert str(environment) in shown
    assert "carry_box" in run(environment, tmp_path, "-m", "motionsplice", "inspect", bank.path)


def test_folders_of_our_folders_names_do_no_harm(environment: Path, tmp_path: Path, bank: Bank) -> None:
    write_foreign_packages(tmp_path)
    run(environment, tmp_path, "-c", "import motionsplice; motionsplice.Bank, motionsplice.Characters")
    assert "carry_box" in run(environment, tmp_path, "-m", "motionsplice", "inspect", bank.path)
