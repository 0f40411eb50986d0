"""Progress of long calls: the caller's own function, or with ``progress=True`` a bar.

The bar is tqdm's (Debian: python3-tqdm), in a notebook with ipywidgets a widget; without tqdm a line on stderr. Both
are drawn ten times a second at most, and cleared at the end, also by an exception. The line has the command's form:
programs that Python runs (``MAILLE_PROGRESS``) write it into a pipe, see ``_command``.
"""

from __future__ import annotations

import os
import sys
import time
import warnings
from contextlib import contextmanager, suppress
from typing import Any, Callable, Iterator, Optional, Union

Tell = Callable[[float, str], object]  #: of the fraction done, 0 to 1, and of what is being done
Progress = Union[Tell, bool, None]

_LINE = "\r\x1b[K"  # writes over the line of a terminal


def of_command() -> bool:
    """True if a program of the command shows its progress, by the rule of terminal.cpp."""
    return sys.stderr.isatty() or "MAILLE_PROGRESS" in os.environ


@contextmanager
def told(progress: Progress) -> Iterator[Optional[Tell]]:
    """The function to call with progress; None without.

    Raises:
        TypeError: neither a function nor True
    """
    if progress is not True:
        if progress and not callable(progress):
            raise TypeError(f"progress: expected True, or a function of a fraction and a text, found {progress!r}")
        yield progress or None
        return
    bar: Any = None
    if "MAILLE_PROGRESS" not in os.environ:
        with suppress(ImportError), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # tqdm misses ipywidgets in some notebooks, and draws text there
            from tqdm.auto import tqdm

            bar = tqdm(total=100, leave=False, bar_format="{percentage:3.0f} %|{bar}| {elapsed} {desc}")
    last = 0.0

    def tell(part: float, what: str) -> None:
        nonlocal last
        if time.monotonic() - last < 0.1:
            return
        last = time.monotonic()
        if bar is None:
            print(f"{_LINE}{100 * part:3.0f} %  {what}", end="", file=sys.stderr, flush=True)
        else:
            bar.n = 100 * part
            bar.set_description_str(what)

    try:
        yield tell
    finally:
        if bar is None:
            print(_LINE, end="", file=sys.stderr, flush=True)
        else:
            bar.close()
