from __future__ import annotations

import os
from pathlib import Path

import pytest

from motionsplice.motion.errors import SettingsError
from motionsplice.motion.toml_file import read_toml

DEEP = 10_000


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"a = " + b"9" * 5000, "not TOML: Exceeds the limit"),
        (b"a = " + b"[" * DEEP + b"]" * DEEP, "nested too deeply"),
        (b"a = " + b"{b = " * DEEP + b"1" + b"}" * DEEP, "nested too deeply"),
        (b"".join(b"[%d.a.b.c.d]\n" % number for number in range(15_000)), "more than one table or list in 16 bytes"),
        (b"a = \xff", "not TOML: .* can't decode.* Save it as UTF-8"),
        (b"[walk", "not TOML: Expected .* end of a table declaration.*Write a name with a colon in quotes"),
    ],
)
def test_what_cannot_be_parsed_is_refused_by_name(content: bytes, problem: str, tmp_path: Path) -> None:
    file = tmp_path / "clips.toml"
    file.write_bytes(content)
    with pytest.raises(SettingsError, match=rf"clips\.toml: .*{problem}"):
        read_toml(file)


def test_a_byte_order_mark_is_left_out(tmp_path: Path) -> None:
    (tmp_path / "clips.toml").write_bytes(b"\xef\xbb\xbf[walk]\r\nkind = 'action'\r\n")
    assert read_toml(tmp_path / "clips.toml") == {"walk": {"kind": "action"}}


def test_what_cannot_be_read_is_refused_by_name(tmp_path: Path) -> None:
    loop = tmp_path / "loop.toml"
    loop.symlink_to(loop)
    for file, problem in ((loop, "symbolic links"), (tmp_path, "a directory"), (tmp_path / "no", "No such file")):
        with pytest.raises(SettingsError, match=f"the file cannot be read: .*{problem}"):
            read_toml(file)
    os.mkfifo(tmp_path / "pipe.toml")
    with pytest.raises(SettingsError, match=r"pipe\.toml: this is a pipe or a device"):
        read_toml(tmp_path / "pipe.toml")
