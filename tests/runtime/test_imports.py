from __future__ import annotations

import subprocess
import sys

FOREIGN = {"fastapi", "uvicorn", "pydantic", "matplotlib", "rich", "typer"}
ABOVE = ("precompute", "service", "commands", "pictures", "cli", "runtime.character")
HEAVY = {"scipy.spatial", "scipy.interpolate", "scipy.optimize", "scipy.sparse", "scipy.linalg", "scipy.ndimage"}


def test_the_evaluator_imports_no_scipy_no_characters_and_no_service() -> None:
    listed = subprocess.run(
        [sys.executable, "-c", "import motionsplice.runtime.evaluator, sys; print('\\n'.join(sys.modules))"],
        capture_output=True,
        text=True,
        check=True,
    )
    modules = set(listed.stdout.split())
    assert "motionsplice.runtime.kernels.evaluate" in modules
    assert not modules & (FOREIGN | HEAVY)  # Numba itself imports SciPy for its version
    assert not [one for one in modules if one.startswith(tuple(f"motionsplice.{name}" for name in ABOVE))]


def test_importing_the_runtime_compiles_nothing() -> None:
    code = "from motionsplice.runtime.kernels.evaluate import evaluate\n"
    code += "from motionsplice.runtime.kernels.world import world_positions\n"
    code += "print(evaluate.signatures, world_positions.signatures)"
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.split() == ["[]", "[]"]
