"""What is wrong with a scene: every fault at once."""

from __future__ import annotations

from typing import NamedTuple, Sequence, Tuple


class Fault(NamedTuple):
    """One thing that is wrong, and what would have been right."""

    file: str  #: empty where the scene is from no file
    line: int  #: from 1; 0 where there is none
    key: str  #: dotted path, such as ``move[1].by``
    expected: str  #: what would have been right
    found: str  #: what is there

    def __str__(self) -> str:
        place = self.file + (f":{self.line}" if self.line else "")
        return ": ".join(part for part in (place, self.key) if part) + f": expected {self.expected}, found {self.found}"


class SceneFaults(ValueError):
    """Raised where a scene, a world or an image is faulty.

    ``faults`` lists all of them, each with its key, what was expected and what was found; ``str()`` has them
    one a line.
    """

    def __init__(self, message: str, faults: Sequence[Tuple[str, int, str, str, str]] = ()) -> None:
        super().__init__(message)
        self.faults = [Fault(*fault) for fault in faults]
