"""Finds the clips of a folder that are not in the bank."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.motion.formats.gltf.writer import dump_glb
from motionsplice.motion.procedural.library import make
from motionsplice.precompute.job.job import build_bank
from motionsplice.runtime.bank import Bank
from motionsplice.service.exchange.pending import Folder
from tests.conftest import COUNTING
from tests.glb_files import with_animation


@pytest.fixture
def clips(hands_folder: Path, tmp_path: Path) -> Path:
    """A copy of a folder with hands, whose bank is built."""
    shutil.copytree(hands_folder, tmp_path / "clips")
    return tmp_path / "clips"


def test_hands_that_are_laid_on_bodies_are_not_pending(clips: Path, hands_bank: Bank) -> None:
    folder = Folder(clips, hands_bank.path)
    assert folder.pending() == {}
    assert folder.missing() == []


def test_changed_hands_are_pending(clips: Path, hands_bank: Bank) -> None:
    (clips / "other_hands.bvh").write_bytes(dump_bvh(COUNTING.hands))
    assert list(Folder(clips, hands_bank.path).pending()) == ["other_hands"]


def test_hands_without_their_file_are_missing(clips: Path, hands_bank: Bank) -> None:
    (clips / "counting_hands.bvh").unlink()
    assert Folder(clips, hands_bank.path).missing() == ["counting_hands"]


def test_settings_of_a_file_with_several_animations_are_known(tmp_path: Path) -> None:
    clips, bank = tmp_path / "clips", tmp_path / "bank"
    clips.mkdir()
    walk, run = make("walk", seconds=3.0), make("run", seconds=3.0)
    (clips / "moves.glb").write_bytes(with_animation(dump_glb(walk), run))
    (clips / "clips.toml").write_text('[moves]\ntags = ["all"]\n["moves:run"]\nkind = "action"\n')
    build_bank([clips], bank)
    assert Folder(clips, bank).pending() == {}
    (clips / "clips.toml").write_text('[moves]\ntags = ["other"]\n')
    assert set(Folder(clips, bank).pending()) == {"moves:run", "moves:walk"}
