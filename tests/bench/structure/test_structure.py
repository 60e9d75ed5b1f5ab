from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import matplotlib.image
import pytest

from bench.structure import package_graph as module
from bench.structure.layers import layers_picture, read_contracts
from bench.structure.package_graph import circles, packages

ROOT = Path(__file__).parents[3]


def test_every_folder_of_modules_is_a_package() -> None:
    found = {package.name: package for package in packages(ROOT)}
    kernels = found["motionsplice.runtime.kernels"]
    assert kernels.modules == len(list((ROOT / "motionsplice" / "runtime" / "kernels").glob("*.py"))) - 1
    assert kernels.longest_chain <= kernels.modules
    assert "motionsplice.runtime.characters" not in kernels.imported
    assert found["motionsplice.runtime.simd"].imported == ("motionsplice.motion",)  # its cache of kernels


def test_no_imports_go_in_a_circle() -> None:
    assert not circles()


@pytest.fixture
def forgotten() -> Iterator[None]:
    """Has this test and the next find the imports anew."""
    module.import_graph.cache_clear()
    yield
    module.import_graph.cache_clear()


@pytest.mark.usefixtures("forgotten")
def test_a_circle_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    package = tmp_path / "circular"
    for name, other in (("a", "b"), ("b", "a")):
        (package / name).mkdir(parents=True)
        (package / name / "__init__.py").write_text("")
        (package / name / "inside.py").write_text(f"import circular.{other}.inside\n")
    (package / "__init__.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setattr(module, "TOP_LEVEL", ("circular",))
    assert [set(circle) for circle in circles()] == [{"circular.a", "circular.b"}]


def test_the_picture_is_drawn_from_the_contracts(tmp_path: Path) -> None:
    contracts = {contract.name: contract for contract in read_contracts(ROOT / "pyproject.toml")}
    assert contracts["project"].rows[-1] == ["motionsplice.motion"]
    assert contracts["runtime"].containers == ("motionsplice.runtime",)
    (tmp_path / "layers.png").write_bytes(layers_picture(list(contracts.values())))
    height, width, _ = matplotlib.image.imread(tmp_path / "layers.png").shape
    assert height > 500
    assert width > 1000
