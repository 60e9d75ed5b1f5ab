"""A hook of mkdocs: links out of `docs` lead to the repository, and pages load nothing from elsewhere."""

from __future__ import annotations

import posixpath
import re
from typing import Any

from mkdocs.exceptions import PluginError

OUTSIDE = re.compile(r"(?<=\]\()(\.\./[^)\s]*)")
FOREIGN = re.compile(r"<(?:script|img|iframe|source)\b[^>]*\bsrc=\"?(?:https?:)?//|<link\b[^>]*stylesheet[^>]*//")


def on_page_markdown(markdown: str, *, page: Any, config: Any, **_: object) -> str:
    """Replaces relative links to files outside `docs` by absolute ones to the repository."""
    folder = posixpath.join("docs", posixpath.dirname(page.file.src_uri))

    def absolute(link: re.Match[str]) -> str:
        target = posixpath.normpath(posixpath.join(folder, link[1]))
        inside = target == "docs" or target.startswith("docs/")
        return link[1] if inside else f"{config.extra['repository']}/blob/main/{target}"

    return OUTSIDE.sub(absolute, markdown)


def on_post_page(output: str, *, page: Any, **_: object) -> str:
    """Returns the page as it is. Raises PluginError if it would load a file from another server."""
    if found := FOREIGN.search(output):
        raise PluginError(f"{page.file.src_uri}: loads a file from another server: {found[0]}. Keep a copy in docs.")
    return output
