"""Reads TOML files of settings."""

from __future__ import annotations

import tomllib
from typing import Any

from motionsplice.motion.errors import SettingsError
from motionsplice.motion.storage.place import Place, may_never_end

BYTES = 16  # of text for each table or list, at least: one that takes two bytes may take a thousand in memory
FREE = 50_000  # tables and lists that a small file may have
COLON = 'Write a name with a colon in quotes, as ["moves:run"]'
UTF_8 = "Save it as UTF-8"


def read_toml(file: Place) -> dict[str, Any]:
    """Returns the tables and values of a file. Raises SettingsError, naming the file."""
    if may_never_end(file):
        raise SettingsError("this is a pipe or a device, not a file", file=str(file))
    try:
        text = file.read_text(encoding="utf-8-sig")  # Windows' editors write a byte order mark
        if sum(map(text.count, ".[{")) > FREE + len(text) // BYTES:
            raise SettingsError(f"more than one table or list in {BYTES} bytes", file=str(file))
        return tomllib.loads(text)
    except OSError as error:
        raise SettingsError(f"the file cannot be read: {error.strerror}", file=str(file)) from None
    except RecursionError:
        raise SettingsError("its lists or tables are nested too deeply", file=str(file)) from None
    except ValueError as error:  # tomllib's own errors, bytes that are no text, and whole numbers of too many digits
        mend = COLON if "table declaration" in str(error) else UTF_8 if isinstance(error, UnicodeError) else ""
        raise SettingsError(f"the file is not TOML: {error}", file=str(file), mend=mend) from None
