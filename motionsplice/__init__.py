"""Splices the upper body of any motion clip onto the lower body of any other, in constant time per frame.

The public names are listed in `__init__.pyi`; each is imported when it is first used.
"""

from pathlib import Path

import lazy_loader

__version__ = "0.2.0"

if not Path(__file__).with_name("runtime").is_dir():  # Git on Windows writes a text file for a link
    raise ImportError(
        "motionsplice/runtime is not a folder: this checkout has no symbolic links. On Windows, turn on developer mode,"
        " then run `git config core.symlinks true` and `git checkout -- motionsplice` (CONTRIBUTING.md)."
    )

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
