"""The rooms of the code: folders with modules, measured by the graph of their imports."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import grimp

PACKAGES = ("motionsplice", "bench")


@dataclass(frozen=True)
class Room:
    """A folder of modules.

    Attributes:
        name: Dotted name of the package.
        modules: How many modules stand in it, apart from `__init__` and its inner rooms.
        lines: Lines of these.
        floors: Length of the longest chain of imports among them.
        inside: Imports among them.
        rooms: Names of the other rooms that they import.
    """

    name: str
    modules: int
    lines: int
    floors: int
    inside: int
    rooms: tuple[str, ...]


@cache
def import_graph() -> grimp.ImportGraph:
    """The imports of all packages."""
    return grimp.build_graph(*PACKAGES)


def rooms(root: Path) -> list[Room]:
    """All rooms below `root`, the folder of the project, by name."""
    graph, modules = import_graph(), defaultdict[str, set[str]](set)
    for module in graph.modules:
        if not graph.find_children(module):
            modules[module.rpartition(".")[0]].add(module)
    return [_room(graph, name, modules[name], root) for name in sorted(modules)]


def circles() -> list[list[str]]:
    """Circles of imports among the children of a package, each with all that is below it."""
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


def _room(graph: grimp.ImportGraph, name: str, modules: set[str], root: Path) -> Room:
    imports = {module: graph.find_modules_directly_imported_by(module) for module in modules}
    inside = {module: found & modules for module, found in imports.items()}
    others = {one.rpartition(".")[0] for found in imports.values() for one in found - modules}
    files = [root.joinpath(*module.split(".")).with_suffix(".py") for module in modules]
    lines = sum(len(file.read_text(encoding="utf-8").splitlines()) for file in files)
    edges = sum(len(found) for found in inside.values())
    return Room(name, len(modules), lines, _floors(inside), edges, tuple(sorted(others - {name, ""})))


def _floors(inside: dict[str, set[str]]) -> int:
    """Modules on the longest chain of imports. Raises RecursionError if they go in a circle."""

    @cache
    def floor(module: str) -> int:
        return 1 + max((floor(one) for one in inside[module]), default=0)

    return max(floor(module) for module in inside)
