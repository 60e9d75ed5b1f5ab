"""Where the command `motionsplice` begins."""

from __future__ import annotations

import sys

from motionsplice import __version__


def main() -> None:
    """Runs the command line. `--version` alone does not load what the commands need."""
    if sys.argv[1:] == ["--version"]:
        print(f"motionsplice {__version__}")
        return
    from motionsplice import cli

    cli.main()


if __name__ == "__main__":
    main()
