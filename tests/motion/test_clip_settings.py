"""What `clips.toml` may say, and what to do about what it may not."""

from __future__ import annotations

from pathlib import Path

import pytest

from motionsplice.motion.clip_settings import FILE_NAME, ClipSettings, read_clip_settings
from motionsplice.motion.errors import SettingsError
from motionsplice.motion.formats.units import metres_per_unit


def read(folder: Path, text: str) -> ClipSettings:
    (folder / FILE_NAME).write_text(text)
    return read_clip_settings(folder / FILE_NAME)["walk"]


@pytest.mark.parametrize(("written", "metres"), [("1", 1.0), ("0.01", 0.01), ("1e-7", 1e-7), ('"cm"', 0.01)])
def test_a_unit_is_a_name_or_a_number(tmp_path: Path, written: str, metres: float) -> None:
    unit = read(tmp_path, f"[walk]\nunit = {written}\n").unit
    assert unit is not None
    assert metres_per_unit(unit) == metres


@pytest.mark.parametrize("written", ["0", "-1.0", "nan", "inf", "true", "[1]"])
def test_a_unit_without_a_length_is_refused(tmp_path: Path, written: str) -> None:
    with pytest.raises(SettingsError, match=r"clip 'walk': invalid value unit = .*such as 0\.01$"):
        read(tmp_path, f"[walk]\nunit = {written}\n")


def test_a_suffix_after_a_clips_name_is_to_be_left_out(tmp_path: Path) -> None:
    with pytest.raises(SettingsError, match=r"unknown key 'fbx'\. Write \[walk\], without the suffix"):
        read(tmp_path, '[walk.fbx]\nkind = "action"\n')
