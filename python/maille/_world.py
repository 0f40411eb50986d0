"""Several objects that share a voxel world, frame by frame."""

from __future__ import annotations

import os
import warnings
from dataclasses import dataclass
from typing import Any, Dict, Iterable, Iterator, List, Optional, Sequence, Tuple, Union

import numpy as np

from . import _core
from ._answer import Floats, Record
from ._faults import MailleWarning, count, existing, number_above_0
from ._scene import Length, PathLike, _metres

Drive = Tuple[str, List[int], Tuple[float, float, float], Tuple[float, float, float], float,
              Optional[Tuple[float, float, float]], bool]


def drive(object: str, *, by: Sequence[Length] = (0, 0, 0), nodes: Sequence[int] = (),
          axis: Sequence[float] = (0, 0, 1), angle: float = 0.0, about: Optional[Sequence[Length]] = None,
          slide: bool = False) -> Drive:
    """What a hand does with an object in one frame.

    Args:
        by: the shift [m], or texts with a unit, in the world's axes
        nodes: of a deformable object: which of its nodes are moved
        axis: of a rigid object's turn
        angle: of the turn [rad]
        about: a point on the axis [m]; without one, the middle of the object's box
        slide: a rigid object goes on along what has stopped it
    """
    x, y, z = (_metres(one) for one in by)
    a, b, c = (float(one) for one in axis)
    point = None if about is None else tuple(_metres(one) for one in about)
    return (object, [int(node) for node in nodes], (x, y, z), (a, b, c), float(angle),
            point, slide)  # type: ignore[return-value]


@dataclass(frozen=True)
class Frame:
    """What became of a frame."""

    number: int  #: from 1
    status: str  #: done, clamped (a drive was cut back), budget_reached or interrupted
    message: str  #: why it is not done; else empty
    seconds: float  #: that it took [s]
    rounds: int  #: answers until everything stood still
    motion_left: Optional[float]  #: that anything would still go until then, estimated; None: not known [m]
    force_left: Optional[float]  #: by which the force on an object would still change, likewise [N]
    drives: List[Record]  #: object, fraction of its motion that was done, force that the hand needs [N]
    contacts: List[Record]  #: object, other (empty: the border), voxel, axis, direction, force [N]
    handed_on: int  #: movements that one voxel handed on to the next
    penetrations: int  #: cells of matter in other matter, or outside; a MailleWarning where there are some


def _frame(number: int, result: Record) -> Frame:
    if result["penetrations"] > 0:
        warnings.warn(f"{result['penetrations']} cells of matter lie in the matter of another object, or outside", MailleWarning, stacklevel=3)
    return Frame(number=number, **result)


class World:
    """Fixed, rigid and deformable objects in one grid of cells: a cell belongs to one of them at most, always.

    Raises:
        SceneFaults: every fault of the file
        ValueError: objects that overlap at the start
    """

    def __init__(self, file: PathLike) -> None:
        self._core = _core.World(existing(file))
        self._played = 0
        for warning in self._core.warnings:
            warnings.warn(warning, MailleWarning, stacklevel=2)

    def __repr__(self) -> str:
        return f"<maille.World {self.name!r}: {', '.join(name for name in self.objects)}>"

    def _repr_html_(self) -> str:
        from ._html import world_html

        return world_html(self)

    @property
    def name(self) -> str:
        return self._core.name

    @property
    def title(self) -> str:
        """Of the file, or its name."""
        return self._core.title

    @property
    def objects(self) -> Dict[str, str]:
        """Names, and whether each is fixed, rigid or deformable."""
        return dict(self._core.objects)

    @property
    def cells(self) -> Tuple[int, int, int]:
        """Of the world, along x, y, z."""
        x, y, z = self._core.cells
        return x, y, z

    @property
    def spacing(self) -> Tuple[float, float, float]:
        """Of a cell [m]."""
        x, y, z = self._core.spacing
        return x, y, z

    def advance(self, drives: Iterable[Drive] = (), *, threads: Optional[int] = None,
                seconds: Optional[float] = None) -> Frame:
        """One frame: driven objects go as far as they can, the others settle. ``seconds``: a budget."""
        result = self._core.advance(list(drives), count("threads", threads or os.cpu_count() or 1), None if seconds is None else number_above_0("seconds", seconds, "1", or_0=True))
        self._played += 1
        return _frame(self._played, result)

    def release(self, object: str) -> None:
        """Lets go of an object: its handles move freely again."""
        self._core.release(object)

    def play(self, file: PathLike, *, threads: Optional[int] = None) -> Iterator[Frame]:
        """Plays recorded input (TOML or CSV, docs/world.md), a frame a step: ``for frame in world.play("press.toml")``.

        The world may be read between two frames.

        Raises:
            SceneFaults: a fault of the file, before the first frame
        """
        trajectory = _core.Trajectory(existing(file), self._core)
        return self._frames(trajectory, count("threads", threads or os.cpu_count() or 1))

    def _frames(self, trajectory: _core.Trajectory, threads: int) -> Iterator[Frame]:
        for number in range(1, trajectory.n_frames + 1):
            result = self._core.play(trajectory, number, threads)
            self._played += 1
            yield _frame(number, result)

    def displacement(self, object: str) -> Floats:
        """Displacement of a deformable object in its own frame [m]: array (nz, ny, nx, 3), a copy."""
        return self._core.displacement(object)

    def pose(self, object: str) -> Floats:
        """From a fixed or rigid object's frame, as its shape has it, to the world: 4 x 4 [m]."""
        return np.array(self._core.pose(object))


__all__ = ["Frame", "World", "drive"]
