"""Finds the clips of a folder that are not in the bank."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from motionsplice.motion.formats.bvh import dump_bvh
from motionsplice.runtime.bank import Bank
from motionsplice.service.exchange.pending import Folder
from tests.conftest import COUNTING


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
