"""The evaluator in C++ opens what `Bank.open` opens, refuses what it refuses, and survives anything."""

from __future__ import annotations

import math
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest

from motionsplice.motion.errors import BankError
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format.manifest import MANIFEST, VERSION, content_digest
from tests.clients import cpp, fuzzed

pytestmark = cpp.needs_compiler
SANITIZED = ["-O1", "-g", "-DREPLAY", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]


@pytest.mark.parametrize("compiler", ["g++", "clang++"])
@pytest.mark.parametrize("options", [["-std=c++17", *cpp.BARE], ["-std=c++20", "-O3"], ["-std=c++17", "-DREPLAY"]])
@pytest.mark.parametrize("source", ["evaluate.cpp", "fuzz.cpp"])
def test_the_header_compiles_without_warnings(source: str, options: list[str], compiler: str) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    cpp.compiled(source, Path("/dev/null"), *options, "-fsyntax-only", compiler=compiler)


@pytest.fixture
def copy(bank: Bank, tmp_path: Path) -> Path:
    """A copy of the bank that a test may damage."""
    return Path(shutil.copytree(bank.path, tmp_path / "bank", ignore=shutil.ignore_patterns("cache")))


def refused_alike(program: Path, bank: Path, same_file: bool = True) -> str:
    """Checks that both implementations refuse a bank, and returns the message of the one in C++."""
    with pytest.raises(BankError) as error:
        Bank.open(bank)
    [line] = cpp.run(program, bank)
    assert line.startswith("error bank ")
    if same_file:
        assert line.startswith(f"error bank {error.value.file}: ")
    return line


def test_damaged_files_are_refused_and_named(copy: Path, program: Path) -> None:
    draw = np.random.default_rng(3)
    for file in [copy / MANIFEST, *sorted((copy / "tables").glob("*.npy"))]:
        sound = file.read_bytes()
        for at in draw.integers(0, len(sound), 4):
            broken = bytearray(sound)
            broken[at] ^= 1 << int(draw.integers(0, 8))
            file.write_bytes(broken)
            refused_alike(program, copy)
        for keep in (0, 1, 100, len(sound) // 2, len(sound) - 1):
            file.write_bytes(sound[:keep])
            refused_alike(program, copy)
        file.unlink()
        refused_alike(program, copy)
        file.mkdir()
        refused_alike(program, copy)
        file.rmdir()
        file.write_bytes(sound)
    assert cpp.run(program, copy) == []


def test_another_version_is_refused_and_named(copy: Path, program: Path) -> None:
    outer = msgpack.unpackb((copy / MANIFEST).read_bytes())
    (copy / MANIFEST).write_bytes(msgpack.packb(outer | {"version": VERSION + 1}))
    assert f"found version {VERSION + 1} of 'motionsplice bank'. Build it again" in refused_alike(program, copy)


def test_a_missing_folder_is_refused(tmp_path: Path, program: Path) -> None:
    assert "Build one with `motionsplice precompute" in refused_alike(program, tmp_path)
    refused_alike(program, tmp_path / "nowhere")


CHANGES: list[Callable[[dict[str, Any]], object]] = [
    lambda body: body["clips"][0].update(row_count=10**9),
    lambda body: body["clips"][0].update(row_count=2**62, first_row=0),
    lambda body: body["clips"][0].update(row_count=-5),
    lambda body: body["clips"][0].update(frame_count=1),
    lambda body: body["clips"][0].update(cell_count=2**63 - 1),
    lambda body: body["clips"][1].update(first_row=0),
    lambda body: body["clips"][0].pop("rate"),
    lambda body: body["clips"][0].update(extra=1),
    lambda body: body["clips"][0].update(rate=30),
    lambda body: body["clips"][0].update(rate=-30.0),
    lambda body: body["clips"][0].update(rate=math.nan),
    lambda body: body["clips"][0].update(loop=True),
    lambda body: body["clips"][0].update(loop=10**6),
    lambda body: body["clips"][0].update(gait=1),
    lambda body: body["clips"][0].update(tags="carry"),
    lambda body: body["clips"][0].update(notes=[1]),
    lambda body: body["clips"][0].update(name=b"walk"),
    lambda body: body["clips"][0].update(name=body["clips"][1]["name"]),
    lambda body: body["clips"][0].update(last_phase=1e300),
    lambda body: body.update(clips=[]),
    lambda body: body.update(clips=3),
    lambda body: body.update(hands=3),
    lambda body: body["roles"].update(pelvis=999),
    lambda body: body["roles"].update(pelvis=0),
    lambda body: body["roles"].update(spine=[1, 2.0]),
    lambda body: body["roles"].update(head=-2),
    lambda body: body["skeleton"].update(parents=[0] * len(body["skeleton"]["names"])),
    lambda body: body["skeleton"]["parents"].append(2**63),
    lambda body: body["skeleton"]["offsets"].pop(),
    lambda body: body["skeleton"]["offsets"][2].pop(),
    lambda body: body["skeleton"]["offsets"][2].__setitem__(1, math.inf),
    lambda body: body["skeleton"].update(end_parents=[999] * len(body["skeleton"]["end_parents"])),
    lambda body: body["skeleton"].update(names=list(range(len(body["skeleton"]["names"])))),
    lambda body: body["skeleton"]["names"].__setitem__(1, body["skeleton"]["names"][2]),
    lambda body: body.pop("mirror"),
    lambda body: body.update(mirror=False),
    lambda body: body.update(mirror=msgpack.ExtType(1, b"")),
    lambda body: body["mirror"].pop("twins"),
    lambda body: body["mirror"].pop("turns"),
    lambda body: body["mirror"]["twins"].pop(),
    lambda body: body["mirror"]["twins"].append(0),
    lambda body: body["mirror"]["twins"].__setitem__(0, -2),
    lambda body: body["mirror"]["twins"].__setitem__(0, len(body["mirror"]["twins"])),
    lambda body: body["mirror"]["twins"].__setitem__(0, 2**63),
    lambda body: body["mirror"]["twins"].__setitem__(0, body["roles"]["left_elbow"]),
    lambda body: body["mirror"]["twins"].__setitem__(0, body["roles"]["pelvis"]),
    lambda body: body["mirror"]["twins"].__setitem__(body["roles"]["left_elbow"], body["roles"]["left_knee"]),
    lambda body: body["mirror"]["twins"].__setitem__(body["roles"]["pelvis"], body["roles"]["left_elbow"]),
    lambda body: body["mirror"]["turns"].pop(),
    lambda body: body["mirror"]["turns"][1].pop(),
    lambda body: body["mirror"]["turns"][1].__setitem__(2, math.nan),
    lambda body: body["mirror"].update(turns=[[0.0, 0.0, 0.0, math.inf]] * len(body["mirror"]["turns"])),
    lambda body: body["baseline"].update(clip="walk~mirror"),
    lambda body: body["tables"].update(lower=body["tables"]["postures"]),
    lambda body: body["tables"].update(lower="../../elsewhere"),
    lambda body: body["tables"].pop("hands"),
    lambda body: body["baseline"].update(clip="absent"),
    lambda body: body["baseline"].update(cells=30.0),
    lambda body: body.update(baseline={}),
    lambda body: body.pop("skeleton"),
]


def rewrite(bank: Path, pack: Callable[[dict[str, Any]], bytes]) -> None:
    """Replaces the body of a manifest; its digest is right."""
    outer = msgpack.unpackb((bank / MANIFEST).read_bytes())
    packed = pack(msgpack.unpackb(outer["body"]))
    (bank / MANIFEST).write_bytes(msgpack.packb(outer | {"body": packed, "digest": content_digest(packed)}))


@pytest.mark.parametrize("change", CHANGES)
def test_an_inconsistent_manifest_with_a_valid_digest_is_refused(
    copy: Path, program: Path, change: Callable[[dict[str, Any]], object]
) -> None:
    def pack(body: dict[str, Any]) -> bytes:
        change(body)
        return bytes(msgpack.packb(body))

    rewrite(copy, pack)
    refused_alike(program, copy, same_file=False)


@pytest.mark.parametrize(
    "packed",
    [
        b"",
        b"\xc1",
        b"\xdf\xff\xff\xff\xff",  # a map of 4 G pairs
        b"\x81\xa8skeleton\x81\xa5names\xdd\xff\xff\xff\xff",  # an array of 4 G items
        b"\x81\xa5clips\xdb\xff\xff\xff\xff",  # 4 GB of text
        b"\x91" * 5000,
        b"\x90",
        b"\x80\x80",
        b"\x81\xa1\xff\x01",
    ],
)
def test_a_body_that_is_no_manifest_is_refused(copy: Path, program: Path, packed: bytes) -> None:
    rewrite(copy, lambda _: packed)
    refused_alike(program, copy)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("lower", np.inf, "not finite"),
        ("upper", np.nan, "not finite"),
        ("phase_of_frame", 0.0, "does not increase"),
        ("phase_of_frame", np.nan, "does not"),
        ("frame_of_phase", np.nan, "not finite"),
        ("paths", -np.inf, "not finite"),
        ("contacts", 4, "bits of feet"),
        ("postures", np.nan, "not finite"),
        ("neutral", 99, "a clip that"),
        ("neutral", -1, "a clip that"),
        ("lower", np.zeros((3, 3), np.float32), "expected"),
        ("lower", np.zeros((3, 3), ">f8"), "expected"),
        ("postures", np.asfortranarray(np.zeros((7, 2, 3))), "expected"),
        ("paths", np.zeros((0, 4)), "expected"),
        ("hands", np.zeros((1, 0), np.float32), "expected"),
    ],
)
def test_an_inconsistent_table_with_a_valid_digest_is_refused(
    copy: Path, program: Path, name: str, value: Any, words: str
) -> None:
    def pack(body: dict[str, Any]) -> bytes:
        table = np.load(copy / "tables" / f"{body['tables'][name]}.npy")
        if isinstance(value, np.ndarray):
            table = value
        else:
            table[3] = value
        np.save(copy / "table.npy", table)
        body["tables"][name] = content_digest((copy / "table.npy").read_bytes())
        (copy / "table.npy").rename(copy / "tables" / f"{body['tables'][name]}.npy")
        return bytes(msgpack.packb(body))

    rewrite(copy, pack)
    assert words in refused_alike(program, copy, same_file=not isinstance(value, np.ndarray))


def damaged(files: list[bytes], draw: np.random.Generator) -> list[bytes]:
    """Returns files of a bank with one to three changes: bits and words anywhere, and spans of the manifest."""
    files = [*files]
    for _ in range(draw.integers(1, 4)):
        number = 0 if draw.random() < 0.5 else int(draw.integers(1, len(files)))
        file, kind = bytearray(files[number]), draw.integers(0, 4 if number == 0 else 2)
        at, to = sorted(draw.integers(0, len(file), 2).tolist())
        if kind == 0:
            file[at] ^= 1 << int(draw.integers(0, 8))
        elif kind == 1:
            file[at : at + 4] = draw.choice([b"\xff" * 4, b"\x7f" * 4, b"\x80\x00\x00\x00", b"\x00\x00\xc0\x7f"])
        elif kind == 2:
            del file[at : min(to, at + 40)]
        else:
            file[at:at] = file[at : min(to, at + 40)]
        files[number] = bytes(file)
    return files


def test_mutated_banks_are_evaluated_or_refused_under_sanitizers(tmp_path: Path) -> None:
    tiny = tmp_path / "tiny.cpp"
    tiny.write_text("int main() {}")
    linked = subprocess.run(["g++", *SANITIZED, tiny, "-o", tmp_path / "tiny"], capture_output=True, check=False)
    if linked.returncode != 0 or subprocess.run([tmp_path / "tiny"], capture_output=True, check=False).returncode != 0:
        pytest.skip("programs with AddressSanitizer do not run here")
    replay = cpp.compiled("fuzz.cpp", tmp_path / "replay", *SANITIZED)
    draw, inputs = np.random.default_rng(11), list[Path]()
    for number, bank in enumerate(fuzzed.small_banks()):
        files = fuzzed.sections(cpp.written(bank, tmp_path / f"bank {number}"))
        for one in [files, *(damaged(files, draw) for _ in range(100))]:
            inputs.append(tmp_path / f"input {len(inputs)}")
            inputs[-1].write_bytes(fuzzed.joined(one))
    done = subprocess.run([replay, *inputs], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    answers = done.stdout.splitlines()
    assert len(answers) == len(inputs)
    assert all(answers[number].startswith("opened") for number in range(0, len(inputs), 101))
    assert sum("manifest" in answer for answer in answers) > 100
    assert sum(answer.startswith("opened") for answer in answers) > 30  # with other numbers in the tables
