"""Compiles kernels once, and reads them from Numba's cache also where it may not be written, as in an image.

Numba reads only folders that it may write, and raises RuntimeError at import if there is none.
"""

from __future__ import annotations

import inspect
import os
from collections.abc import Callable
from contextlib import suppress
from itertools import takewhile
from typing import Any

from numba import njit  # noqa: TID251
from numba.core import config
from numba.core.caching import (
    CompileResultCacheImpl,
    FunctionCache,
    IndexDataCacheFile,
    _CacheLocator,
    _SourceFileBackedLocatorMixin,
)


def compiled(**options: Any) -> Callable[[Callable[..., Any]], Any]:
    """Returns a decorator like `njit(cache=True, **options)`, for which a folder that it may not write is no error."""

    def compile_once(function: Callable[..., Any]) -> Any:
        dispatcher = njit(**options)(function)
        if dispatcher is not function:  # as it is with NUMBA_DISABLE_JIT
            dispatcher._cache = KernelCache(function)
        return dispatcher

    return compile_once


class Unwritable(_SourceFileBackedLocatorMixin, _CacheLocator):
    """The folder of a kernel's source, which is read if no folder may be written."""

    def __init__(self, function: Callable[..., Any], source: str) -> None:
        self._py_file = source
        self._lineno = function.__code__.co_firstlineno

    def get_cache_path(self) -> str:
        return beside(self._py_file)

    def ensure_cache_path(self) -> None:
        """Checks nothing: what was compiled lives as long as the process, since saving it fails."""


class Results(CompileResultCacheImpl):
    _locator_classes = [*CompileResultCacheImpl._locator_classes, Unwritable]  # noqa: RUF012  as Numba declares it


class KernelCache(FunctionCache):
    """Numba's cache of a kernel, which also reads the folders that Numba prefers to its own but may not write."""

    _impl_class = Results

    def __init__(self, function: Callable[..., Any]) -> None:
        super().__init__(function)
        locator, source = self._impl.locator, inspect.getfile(function)
        preferred = [beside(source)]
        if chosen := config.CACHE_DIR:  # type: ignore[attr-defined]
            preferred.insert(0, os.path.join(chosen, locator.get_suitable_cache_subpath(source)))
        self._readable = [
            IndexDataCacheFile(folder, self._impl.filename_base, locator.get_source_stamp())
            for folder in takewhile(lambda folder: folder != self.cache_path, preferred)
        ]

    def _load_overload(self, sig: Any, target_context: Any) -> Any:
        key = self._index_key(sig, target_context.codegen())
        for file in (*self._readable, self._cache_file):
            with suppress(OSError):
                if (found := file.load(key)) is not None:
                    return self._impl.rebuild(target_context, found)
        return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Saves a compiled kernel if the folder can be written, and has room; a kernel that is not saved works too."""
        with suppress(OSError):
            super().save_overload(sig, data)


def beside(source: str) -> str:
    """Returns the folder beside a source file in which Python and Numba cache."""
    return os.path.join(os.path.dirname(source), "__pycache__")
