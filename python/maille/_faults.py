"""What is wrong with a scene: every fault at once."""

from __future__ import annotations

import errno
import os
from typing import NamedTuple, Sequence, Tuple, Union


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

    ``faults`` lists all of them, each with its key, what was expected and what was found; ``str()`` has them
    one a line.
    """

    def __init__(self, message: str, faults: Sequence[Tuple[str, int, str, str, str]] = ()) -> None:
        super().__init__(message)
        self.faults = [Fault(*fault) for fault in faults]


def existing(file: Union[str, "os.PathLike[str]"]) -> str:
    """The file's name. @raises FileNotFoundError"""
    if not os.path.exists(file):
        raise FileNotFoundError(errno.ENOENT, os.strerror(errno.ENOENT), os.fspath(file))
    return os.fspath(file)
