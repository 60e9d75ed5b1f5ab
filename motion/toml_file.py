"""Reads TOML files of settings."""

from __future__ import annotations

import tomllib
from typing import Any

from motionsplice.motion.errors import SettingsError
from motionsplice.motion.storage.place import Place

COLON = 'Write a name with a colon in quotes, as ["moves:run"]'


def read_toml(file: Place) -> dict[str, Any]:
    """Returns the tables and values of a file. Raises SettingsError, naming the file."""
    try:
        return tomllib.loads(file.read_text(encoding="utf-8"))
    except OSError as error:
        raise SettingsError(f"the file cannot be read: {error.strerror}", file=str(file)) from None
    except RecursionError:
        raise SettingsError("its lists or tables are nested too deeply", file=str(file)) from None
    except ValueError as error:  # tomllib's own errors, bytes that are no text, and whole numbers of too many digits
        mend = COLON if "table declaration" in str(error) else ""
        raise SettingsError(f"the file is not TOML: {error}", file=str(file), mend=mend) from None
