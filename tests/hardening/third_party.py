"""What others wrote and users install with the package: `python -m tests.hardening.third_party > THIRD_PARTY.md`.

Names, licences and addresses come from the metadata of the installed packages.
"""

from __future__ import annotations

from importlib.metadata import Distribution, PackageNotFoundError, distribution

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

PACKAGE, EXTRAS = "motionsplice", ("", "cluster", "fbx", "s3")  # those of the image
LONGEST = 60  # characters of a licence's name; some packages give its whole text
INTRODUCTION = """# What others wrote

The viewer's page comes with [three.js](https://threejs.org) (MIT; its licence is
[beside it](service/viewer/page/vendor/three.LICENSE)). Everything below is installed with motionsplice, and not part of
it; some only with the extras `cluster`, `fbx` and `s3`, which the image has. Each package's licence is in its own
distribution. `make supply` writes this list, the pinned versions in [`constraints.txt`](constraints.txt), and an SBOM.

| package | licence | address |
|---|---|---|
"""


def packages() -> dict[str, Distribution]:
    """Returns the packages that are installed with ours, by name, all that they require included."""
    found: dict[str, Distribution] = {}
    waiting: list[tuple[str, tuple[str, ...]]] = [(PACKAGE, EXTRAS)]
    while waiting:
        name, extras = waiting.pop()
        for line in distribution(name).requires or ():
            one = Requirement(line)
            if canonicalize_name(one.name) not in found and _is_needed(one, extras):
                try:
                    found[canonicalize_name(one.name)] = distribution(one.name)
                except PackageNotFoundError:  # for another version of Python
                    continue
                waiting.append((one.name, ("", *one.extras)))
    return dict(sorted(found.items()))


def _is_needed(one: Requirement, extras: tuple[str, ...]) -> bool:
    return one.marker is None or any(one.marker.evaluate({"extra": extra}) for extra in extras)


def licence(package: Distribution) -> str:
    """Returns the licence of a package, as its metadata names it."""
    classes = [line.rpartition(" :: ")[2] for line in _all(package, "Classifier") if line.startswith("License ::")]
    text = [line.partition("\n")[0] for line in _all(package, "License")]
    given = [*_all(package, "License-Expression"), ", ".join(classes), *text]
    return next((one for one in given if one and len(one) <= LONGEST), "see its distribution")


def address(package: Distribution) -> str:
    """Returns the address of a package's project."""
    listed = [line.partition(", ") for line in _all(package, "Project-URL")]
    urls = {label.lower(): url for label, _, url in listed}
    known = [urls[label] for label in ("homepage", "source", "source code", "repository", "github") if label in urls]
    return next(iter([*_all(package, "Home-page"), *known, *urls.values()]), "")


def _all(package: Distribution, key: str) -> list[str]:
    return package.metadata.get_all(key) or []


if __name__ == "__main__":
    rows = (f"| {name} | {licence(one)} | {address(one)} |" for name, one in packages().items())
    print(INTRODUCTION + "\n".join(rows))
