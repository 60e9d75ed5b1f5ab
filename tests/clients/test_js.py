"""The JavaScript client (clients/js): unit tests, types, and the client in Node and Chromium on a live service."""

from __future__ import annotations

import json
import shutil
import subprocess
import tarfile
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from pydantic import SecretStr

from bench.chromium import CHROMIUM
from motionsplice import __version__
from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.procedural.library import make
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.service.serving import Edition
from motionsplice.service.settings import Settings
from tests.characters import character_file
from tests.clients.happenings import lose
from tests.clients.processes import MINUTES, started
from tests.clients.samples import placed
from tests.oracles.three import shared_rig
from tests.service.running import Running, running

CLIENT = Path(__file__).parents[2] / "clients" / "js"
MISSING = (
    "Node is not installed"
    if shutil.which("node") is None
    else ""
    if (CLIENT / "node_modules").is_dir()
    else "its packages are not installed: npm ci --prefix clients/js"
)
pytestmark = pytest.mark.skipif(bool(MISSING), reason=MISSING)


def script(name: str, *arguments: object) -> AbstractContextManager[Callable[[], dict[str, Any]]]:
    """Runs a script of the client, and gives the function that returns what its next line says."""
    return started("node", CLIENT / "tests" / name, *arguments)


def npx(*arguments: object, folder: Path = CLIENT) -> str:
    command = [str(CLIENT / "node_modules" / ".bin" / str(arguments[0])), *map(str, arguments[1:])]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False, timeout=MINUTES)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_its_unit_tests_pass() -> None:
    command = ["node", "--test", "--test-reporter=spec", "tests/"]
    done = subprocess.run(command, cwd=CLIENT, capture_output=True, text=True, check=False, timeout=MINUTES)
    assert done.returncode == 0, done.stdout


def test_joints_are_where_the_service_has_them_through_an_exchange_and_a_reconnection(
    service: Running, bank: Bank, other: Bank
) -> None:
    front, loop = service.config.front, service.server.servers[0].get_loop()
    newer = Edition.warm(other)
    with script("live.mjs", service.url) as line:
        assert line() == {"ready": True}
        loop.call_soon_threadsafe(front.shared.serving.exchange, newer)
        assert line() == {"exchanged": True}
        loop.call_soon_threadsafe(lose, front)
        results = line()["results"]
    assert {(one["encoding"], one["ahead"]) for one in results} == {
        (encoding, ahead) for encoding in ("float32", "int16") for ahead in (1, 8)
    }
    for one in results:
        assert one["frames"] >= 1000
        assert one["banks"] == [bank.digest, other.digest]
        assert one["worst"] < (1e-5 if one["encoding"] == "float32" else 3e-4)  # of which int16 is nearly all
        assert (one["failed"], one["characters"]) == (0, 3)
        assert 0.25 <= one["retry"] <= 0.5
        assert one["isHeld"]
        assert one["jump"] < 0.3  # metres: it goes on where it was, at another phase of the stride
        assert len(one["samples"]) == 10
        for sample in one["samples"]:
            assert np.abs(placed(sample, one["encoding"]) - sample["positions"]).max() < 1e-5


MADE = {"plain": (1.0, None), "turned and scaled": (100.0, 2)}  # scale of an armature, seed of the bones' own axes


@pytest.mark.parametrize("name", [*MADE, "robot.glb", "m2m-human-addon-animations.glb"])
def test_bones_of_a_characters_own_file_are_where_the_service_has_its_joints(tmp_path: Path, name: str) -> None:
    if name in MADE:
        scale, seed = MADE[name]
        hero = tmp_path / "hero.glb"
        hero.write_bytes(character_file(make("walk", seconds=1.0).skeleton.scaled(0.8), scale=scale, seed=seed))
    else:
        hero = shared_rig(name)
    for action, clip in {"walk": make("walk", seed=1), "carry_box": make("walk", "carry_box", seed=6)}.items():
        (tmp_path / f"{action}.bvh").write_bytes(dump_bvh(clip))
    clips = [tmp_path / "walk.bvh", tmp_path / "carry_box.bvh"]
    build_bank(clips, tmp_path / "bank", baseline="walk", skeleton=hero)
    with running(tmp_path / "bank", Settings()) as service, script("bones.mjs", service.url, hero) as line:
        found = line()
    assert max(found["worst"].values()) < 1e-5, found
    if name in MADE:
        assert found["vertex"] < 0.5


def test_splices_and_streams_over_http_are_the_same_frames(bank: Bank) -> None:
    settings = Settings(token=SecretStr("secret-token"))
    with running(bank.path, settings) as service, script("http.mjs", service.url, "secret-token") as line:
        found = line()
    no_token, unknown, nobody, wrong = found["refused"]
    assert no_token.startswith("RefusedError token the token is missing or wrong")
    assert unknown.startswith("RefusedError unknown-clip the bank has no clip 'wlak'. Did you mean 'walk'")
    assert nobody.startswith("ConnectionLostError  no answer from http://127.0.0.1:")
    assert wrong.startswith("RefusedError token the token is missing or wrong")
    assert found["worst"]["float32"] < 1e-5
    assert found["worst"]["int16"] < 1e-4
    assert found["worst"]["take"] < 1e-5
    assert found["seen"] == 3


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A project that has installed the package, as npm would publish it."""
    project = tmp_path_factory.mktemp("project")
    copy = project / "copy"
    shutil.copytree(CLIENT, copy, ignore=shutil.ignore_patterns("node_modules", "types"))
    (copy / "node_modules").symlink_to(CLIENT / "node_modules")
    pack = ["npm", "pack", "--silent", "--pack-destination", str(project)]
    subprocess.run(pack, cwd=copy, check=True, capture_output=True)
    (archive,) = project.glob("motionsplice-*.tgz")
    with tarfile.open(archive) as opened:
        opened.extractall(project / "node_modules", filter="data")
    (project / "node_modules" / "package").rename(project / "node_modules" / "motionsplice")
    for name in ("three", "@types"):
        (project / "node_modules" / name).symlink_to(CLIENT / "node_modules" / name)
    return project


def test_the_package_has_what_a_user_needs_and_no_more(package: Path) -> None:
    installed = package / "node_modules" / "motionsplice"
    names = {file.name for file in installed.iterdir()}
    assert names == {"package.json", "motionsplice.js", "source", "types", "README.md", "LICENSE"}
    assert {file.suffix for file in (installed / "source").iterdir()} == {".js"}
    described = json.loads((installed / "package.json").read_text())
    assert "dependencies" not in described
    assert not {"preinstall", "install", "postinstall", "prepare"} & described["scripts"].keys()
    assert described["version"] == __version__.replace(".dev0", "")


def test_a_users_file_in_typescript_is_accepted(package: Path) -> None:
    shutil.copy(CLIENT / "tests" / "user.ts", package)
    (package / "package.json").write_text('{"type": "module"}')
    modern = ["--module", "nodenext", "--target", "es2022", "--lib", "es2022,dom,dom.asynciterable"]
    npx("tsc", "--strict", "--noEmit", "--skipLibCheck", *modern, "user.ts", folder=package)
    code = "import { connect } from 'motionsplice'; connect.call"
    subprocess.run(["node", "--input-type=module", "-e", code], cwd=package, check=True)


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_the_example_page_shows_a_character_that_moves(service: Running, tmp_path: Path) -> None:
    with script("browser.mjs", CHROMIUM, service.url, tmp_path) as line:
        assert line() == {"problems": [], "elsewhere": []}
    first, second = (
        np.asarray(Image.open(tmp_path / f"{name}.png").convert("RGB"), int) for name in ("first", "second")
    )
    for picture in (first, second):
        orange = (picture[..., 0] > 150) & (picture[..., 2] < 60)
        rows, columns = np.nonzero(orange)
        assert orange.sum() > 4000
        assert 200 < np.ptp(rows) < 330  # a standing person
        assert 40 < np.ptp(columns) < 260
    assert (np.abs(first - second).max(axis=2) > 60).sum() > 2000
