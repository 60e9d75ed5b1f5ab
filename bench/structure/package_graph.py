"""The packages of the code, measured by the graph of their imports."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import grimp

TOP_LEVEL = ("motionsplice", "bench")


@dataclass(frozen=True)
class Package:
    """A package, measured by its own modules, without its subpackages.

    Attributes:
        name: Dotted name of the package.
        modules: Number of modules, without `__init__`.
        lines: Lines of these modules.
        longest_chain: Modules on the longest chain of imports among them.
        inside: Imports among them.
        imported: Names of the other packages that they import.
    """

    name: str
    modules: int
    lines: int
    longest_chain: int
    inside: int
    imported: tuple[str, ...]


@cache
def import_graph() -> grimp.ImportGraph:
    """Returns the imports of all packages."""
    return grimp.build_graph(*TOP_LEVEL)


def packages(root: Path) -> list[Package]:
    """Returns all packages below `root`, the folder of the project, in order of name."""
    graph, modules = import_graph(), defaultdict[str, set[str]](set)
    for module in graph.modules:
        if not graph.find_children(module):
            modules[module.rpartition(".")[0]].add(module)
    return [_package(graph, name, modules[name], root) for name in sorted(modules)]


def circles() -> list[list[str]]:
    """Returns the circles of imports among the children of each package. A child stands for all modules below it."""
    graph, found = import_graph(), []
    for package in sorted(module for module in graph.modules if graph.find_children(module)):
        children = {child: {child, *graph.find_descendants(child)} for child in graph.find_children(package)}
        imports = {
            child: {
                other
                for other, theirs in children.items()
                if other != child and any(graph.find_modules_directly_imported_by(one) & theirs for one in own)
            }
            for child, own in children.items()
        }
        try:
            TopologicalSorter(imports).prepare()
        except CycleError as error:
            found.append(error.args[1])
    return found


def _package(graph: grimp.ImportGraph, name: str, modules: set[str], root: Path) -> Package:
    imports = {module: graph.find_modules_directly_imported_by(module) for module in modules}
    inside = {module: found & modules for module, found in imports.items()}
    others = {one.rpartition(".")[0] for found in imports.values() for one in found - modules}
    files = [root.joinpath(*module.split(".")).with_suffix(".py") for module in modules]
    lines = sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)
    edges = sum(len(found) for found in inside.values())
    return Package(name, len(modules), lines, _longest_chain(inside), edges, tuple(sorted(others - {name, ""})))


def _longest_chain(inside: dict[str, set[str]]) -> int:
    """Counts the modules on the longest chain of imports. Raises RecursionError if there is a circle."""

    @cache
    def chain(module: str) -> int:
        return 1 + max((chain(one) for one in inside[module]), default=0)

    return max(chain(module) for module in inside)
