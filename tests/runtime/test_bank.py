from __future__ import annotations

import io
import os
import shutil
import struct
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest

from motionsplice.motion.errors import LONGEST_NAME, BankError, UnknownClipError, did_you_mean
from motionsplice.runtime.bank import Bank
from motionsplice.runtime.format import tables
from motionsplice.runtime.format.manifest import MANIFEST, TABLES, VERSION, Manifest, content_digest


@pytest.fixture
def copy(bank: Bank, tmp_path: Path) -> Path:
    """A copy of the bank that a test may damage."""
    return Path(shutil.copytree(bank.path, tmp_path / "bank"))


def test_a_bank_holds_its_clips_and_their_settings(bank: Bank) -> None:
    assert {clip.name for clip in bank.clips} >= {"walk", "run", "carry_box"}
    assert bank.clip("carry_box").kind == "action"
    assert bank.clip("carry_box").tags == ("carry",)
    assert bank.neutral("carry_box") == "walk"
    assert bank.neutral("run") == "run"
    assert bank.baseline.clip == "walk"
    for clip in bank.clips:
        phase = bank.tables["phase_of_frame"][clip.first_row : clip.first_row + clip.row_count]
        assert np.diff(phase).min() > 0.0
        assert (phase[0], phase[-1]) == (clip.first_phase, clip.last_phase)
        assert clip.cycles == pytest.approx(phase[clip.frame_count - 1] - phase[0])
        assert bank.motion(clip.name).frame_count == clip.frame_count


def test_frame_of_phase_is_the_inverse_of_phase_of_frame(bank: Bank) -> None:
    for clip in bank.clips:
        phase = bank.tables["phase_of_frame"][clip.first_row : clip.first_row + clip.row_count]
        frames = bank.tables["frame_of_phase"][clip.first_cell : clip.first_cell + clip.cell_count]
        grid = np.linspace(clip.first_phase, clip.last_phase, clip.cell_count)
        np.testing.assert_allclose(np.interp(phase, grid, frames), np.arange(clip.row_count), atol=0.2)


def test_tables_cannot_be_written(bank: Bank) -> None:
    for name in TABLES:
        with pytest.raises(ValueError, match="read-only"):
            bank.tables[name].flat[0] = 0


def test_tables_of_a_large_bank_are_mapped_and_equal(bank: Bank, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tables, "SMALL", 0)
    mapped = Bank.open(bank.path)
    for name in TABLES:
        assert isinstance(mapped.tables[name].base, np.memmap)
        assert (mapped.tables[name].dtype, mapped.tables[name].ctypes.data % 64) == (bank.tables[name].dtype, 0)
        assert bank.tables[name].ctypes.data % 64 == 0
        np.testing.assert_array_equal(mapped.tables[name], bank.tables[name])


def test_a_bank_that_is_replaced_while_it_is_opened_is_read_anew(copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    current, names = Manifest.read(copy), dict.fromkeys(TABLES, "0" * 32)
    read = iter([replace(current, data=b"", tables=names), current])
    monkeypatch.setattr(Manifest, "read", lambda folder: next(read))
    assert Bank.open(copy).digest == current.digest


def test_a_small_bank_survives_that_its_files_are_cut_short_while_in_use(copy: Path) -> None:
    """A process that reads mapped pages beyond the end of their file is killed."""
    bank = Bank.open(copy)
    before = {name: table.copy() for name, table in bank.tables.items()}
    for file in bank.files.values():
        os.truncate(file, 0)
    for name, table in before.items():
        np.testing.assert_array_equal(bank.tables[name], table)


def test_the_error_of_an_unknown_clip_suggests_similar_names(bank: Bank) -> None:
    with pytest.raises(UnknownClipError, match="Did you mean 'carry_box'"):
        bank.number("carrybox")


def test_missing_folders_and_folders_without_a_bank_are_refused(tmp_path: Path) -> None:
    with pytest.raises(BankError, match=r"folder not found.*Build one"):
        Bank.open(tmp_path / "nowhere")
    with pytest.raises(BankError, match=r"not a bank.*Build one"):
        Bank.open(tmp_path)


def test_another_version_is_refused_and_named(copy: Path) -> None:
    outer = msgpack.unpackb((copy / MANIFEST).read_bytes())
    (copy / MANIFEST).write_bytes(msgpack.packb(outer | {"version": VERSION + 1}))
    with pytest.raises(BankError, match=rf"expected version {VERSION} .* found version {VERSION + 1} .*precompute"):
        Bank.open(copy)


@pytest.mark.parametrize("keep", [0, 1, 100, -1])
def test_a_truncated_manifest_is_refused(copy: Path, keep: int) -> None:
    (copy / MANIFEST).write_bytes((copy / MANIFEST).read_bytes()[:keep])
    with pytest.raises(BankError, match=r"manifest\.msgpack: the manifest"):
        Bank.open(copy)


def test_a_table_that_is_cut_while_it_is_read_is_refused(copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fstat = os.fstat

    def cut_after(descriptor: int) -> os.stat_result:
        found = fstat(descriptor)
        for file in (copy / "tables").iterdir():
            if file.stat().st_ino == found.st_ino:
                os.truncate(file, 200)
        return found

    monkeypatch.setattr(os, "fstat", cut_after)
    with pytest.raises(BankError, match="cut short"):
        Bank.open(copy, verify=False)


def test_a_missing_truncated_or_bit_flipped_file_is_refused(copy: Path) -> None:
    draw = np.random.default_rng(5)
    for file in [copy / MANIFEST, *sorted((copy / "tables").glob("*.npy"))]:
        sound = file.read_bytes()
        for at in draw.integers(0, len(sound), 12):
            broken = bytearray(sound)
            broken[at] ^= 1 << int(draw.integers(0, 8))
            file.write_bytes(broken)
            with pytest.raises(BankError, match="precompute"):
                Bank.open(copy)
        file.write_bytes(sound[: len(sound) // 2])
        with pytest.raises(BankError, match="cut short"):
            Bank.open(copy)
        file.unlink()
        with pytest.raises(BankError, match=r"missing|not a bank"):
            Bank.open(copy)
        file.write_bytes(sound)
    assert Bank.open(copy).clips


def test_an_inconsistent_manifest_with_a_valid_digest_is_refused(copy: Path) -> None:
    outer = msgpack.unpackb((copy / MANIFEST).read_bytes())
    changes: list[Callable[[dict[str, Any]], object]] = [
        lambda body: body["clips"][0].update(row_count=10**9),
        lambda body: body["clips"][1].update(first_row=0),
        lambda body: body["clips"][0].pop("rate"),
        lambda body: body["clips"][0].update(name=body["clips"][1]["name"]),
        lambda body: body.update(clips=[]),
        lambda body: body["roles"].update(pelvis=999),
        lambda body: body["skeleton"].update(parents=[0] * len(body["skeleton"]["names"])),
        lambda body: body["tables"].update(lower=body["tables"]["postures"]),
        lambda body: body["tables"].update(lower="../../elsewhere"),
        lambda body: body["tables"].update(lower="a" * 5000),
        lambda body: body["tables"].update(lower=["a"]),
        lambda body: body["roles"].update(left_wrist=-1),
        lambda body: body["skeleton"]["offsets"][2].__setitem__(0, 1e300),
        lambda body: body.pop("skeleton"),
        lambda body: body.update(baseline={}),
        lambda body: body["baseline"].update(clip="absent"),
        lambda body: body["skeleton"].update(end_parents=[999] * len(body["skeleton"]["end_parents"])),
        lambda body: body["skeleton"]["parents"].append(2**63),
        lambda body: body["skeleton"].update(names=list(range(len(body["skeleton"]["names"])))),
        lambda body: body.pop("mirror"),
        lambda body: body["mirror"].update(more=1),
        lambda body: body["mirror"]["twins"].pop(),
        lambda body: body["mirror"]["twins"].__setitem__(0, 0.0),
        lambda body: body["mirror"]["twins"].__setitem__(0, 2),  # a joint of the other half
        lambda body: body["mirror"]["twins"].__setitem__(1, -2),
        lambda body: body["mirror"]["turns"].__setitem__(0, [0.0, 0.0, 1.0]),
        lambda body: body["mirror"]["turns"][0].__setitem__(0, float("nan")),
        lambda body: body["mirror"]["turns"][0].__setitem__(3, 1),
        lambda body: body["mirror"]["turns"][0].__setitem__(3, 1e300),
    ]
    for change in changes:
        write_manifest(copy, outer, change)
        with pytest.raises(BankError):
            Bank.open(copy)


def test_a_table_that_kernels_cannot_read_in_place_is_refused(copy: Path) -> None:
    outer = msgpack.unpackb((copy / MANIFEST).read_bytes())
    data = (copy / "tables" / f"{msgpack.unpackb(outer['body'])['tables']['paths']}.npy").read_bytes()
    end = data.index(b"\n")
    shifted = data[:8] + struct.pack("<H", end - 10) + data[10 : end - 1] + data[end:]  # a header shorter by a blank
    digest = content_digest(shifted)
    (copy / "tables" / f"{digest}.npy").write_bytes(shifted)
    write_manifest(copy, outer, lambda body: body["tables"].update(paths=digest))
    for verify in (True, False):
        with pytest.raises(BankError, match="table 'paths' does not begin at a multiple of 8 bytes"):
            Bank.open(copy, verify=verify)


def test_a_very_long_unknown_name_is_refused_at_once_and_not_repeated(bank: Bank) -> None:
    with pytest.raises(UnknownClipError, match=r"has no clip 'walkwalk.*Choose one of carry_box") as caught:
        bank.number("walk" * 10**6)  # to compare it with all names would take seconds
    assert len(str(caught.value)) < 500
    assert did_you_mean("x" * (LONGEST_NAME + 1), ["x" * LONGEST_NAME]).startswith("Choose one of")
    assert did_you_mean("x" * LONGEST_NAME, ["x" * (LONGEST_NAME - 1)]).startswith("Did you mean")


def test_a_name_that_only_looks_the_same_is_written_out() -> None:
    apart, composed = "Gru\u0308ße", "Grüße"
    assert did_you_mean(composed, [apart, composed[:-1]]).startswith(f"Did you mean {apart!a}? It looks the same")
    assert did_you_mean(apart, [composed]).startswith(f"Did you mean {composed!a}? It looks the same")


def write_manifest(bank: Path, outer: dict[str, Any], change: Callable[[dict[str, Any]], object]) -> None:
    """Rewrites the manifest with a change to its body and a valid digest."""
    body = msgpack.unpackb(outer["body"])
    change(body)
    packed = msgpack.packb(body)
    (bank / MANIFEST).write_bytes(msgpack.packb(outer | {"body": packed, "digest": content_digest(packed)}))


@pytest.mark.parametrize(
    ("part", "field", "value"),
    [
        ("clips", "rate", "30"),
        ("clips", "rate", 30),
        ("clips", "mean_mismatch", float("nan")),
        ("clips", "loop", 1.0),
        ("clips", "loop", True),
        ("clips", "name", b"walk"),
        ("clips", "tags", "carry"),
        ("clips", "notes", [1]),
        ("clips", "warnings", None),
        ("baseline", "clip", 3),
        ("baseline", "start", [0.0]),
        ("baseline", "cells", 30.0),
        ("roles", "pelvis", 1.0),
        ("roles", "spine", [1, 2.0]),
        ("roles", "head", None),
    ],
)
def test_a_field_of_the_wrong_type_is_refused_and_named(copy: Path, part: str, field: str, value: object) -> None:
    def change(body: dict[str, Any]) -> None:
        (body[part][0] if part == "clips" else body[part])[field] = value

    write_manifest(copy, msgpack.unpackb((copy / MANIFEST).read_bytes()), change)
    with pytest.raises(BankError, match=rf"manifest\.msgpack: the manifest has {field} = .* expected .*precompute"):
        Bank.open(copy)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("phase_of_frame", 0.0, "does not increase"),
        ("frame_of_phase", np.nan, "not finite"),
        ("neutral", 99, "a clip that"),
    ],
)
def test_an_inconsistent_table_with_a_valid_digest_is_refused(copy: Path, name: str, value: float, words: str) -> None:
    outer = msgpack.unpackb((copy / MANIFEST).read_bytes())
    body = msgpack.unpackb(outer["body"])
    table = np.load(copy / "tables" / f"{body['tables'][name]}.npy")
    table[3] = value
    sink = io.BytesIO()
    np.save(sink, table)
    body["tables"][name] = content_digest(sink.getvalue())
    (copy / "tables" / f"{body['tables'][name]}.npy").write_bytes(sink.getvalue())
    packed = msgpack.packb(body)
    manifest = outer | {"body": packed, "digest": content_digest(packed)}
    (copy / MANIFEST).write_bytes(msgpack.packb(manifest))
    with pytest.raises(BankError, match=words):
        Bank.open(copy)
