"""What is wrong with a scene: every fault at once."""

from __future__ import annotations

import errno
import math
import numbers
import os
from typing import Any, NamedTuple, Sequence, Tuple, Union


class Fault(NamedTuple):
    """One thing that is wrong, and what would have been right."""

    file: str  #: empty where the scene is from no file
    line: int  #: from 1; 0 if unknown
    key: str  #: dotted path, such as ``move[1].by``
    expected: str  #: what would have been right
    found: str  #: what is there

    def __str__(self) -> str:
        place = self.file + (f":{self.line}" if self.line else "")
        return ": ".join(part for part in (place, self.key) if part) + f": expected {self.expected}, found {self.found}"


class MailleWarning(UserWarning):
    """What the command prints as a warning: an answer that is not what it seems, or a question out of proportion."""


class SceneFaults(ValueError):
    """Raised where a scene, a world or an image is faulty.

    one a line.

    Args:
        faults: lists all of them, each with its key, what was expected and what was found; ``str()`` has them
    """

    def __init__(self, message: str, faults: Sequence[Tuple[str, int, str, str, str]] = ()) -> None:
        super().__init__(message)
        self.faults = [Fault(*fault) for fault in faults]


def number_above_0(name: str, value: Any, example: str, *, or_0: bool = False) -> float:
    """A finite argument > 0, or >= 0.

    Raises:
        TypeError: not a number
        ValueError: not finite, or below
    """
    is_number = isinstance(value, numbers.Real) and not isinstance(value, bool)
    if is_number and math.isfinite(value) and (value > 0 or or_0 and value == 0):
        return float(value)
    raise (ValueError if is_number else TypeError)(f"{name}: expected a number >{'=' * or_0} 0 such as {example}, found {value!r}")


def count(name: str, value: Any) -> int:
    """An integer argument from 1 on.

    Raises:
        TypeError: not an integer
        ValueError: below 1
    """
    is_whole = isinstance(value, numbers.Integral) and not isinstance(value, bool)
    if is_whole and value >= 1:
        return int(value)
    raise (ValueError if is_whole else TypeError)(f"{name}: expected a whole number from 1, found {value!r}")


def existing(file: Union[str, "os.PathLike[str]"]) -> str:
    """The name of the file.

    Raises:
        FileNotFoundError: there is no such file
    """
    if not os.path.exists(file):
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), os.fspath(file))
    return os.fspath(file)
