"""Answers step by step: from rest to the whole of moves and loads, in steps of equal size, as ``maille run --steps``."""

from __future__ import annotations

import warnings
from typing import TYPE_CHECKING, Any, Iterable, List, Optional

import numpy as np

from . import _core
from ._answer import Answer, Floats, Record
from ._faults import MailleWarning, count
from ._progress import Tell

if TYPE_CHECKING:
    from ._scene import Scene


class Series(List[Answer]):
    """A list of answers, one a step; each is a quasi-static answer to its ``fraction`` of moves and loads."""

    def __init__(self, answers: Iterable[Answer] = (), steps: int = 0) -> None:
        super().__init__(answers)
        self.steps = steps  #: that were asked

    def __repr__(self) -> str:
        return f"<maille.Series of {len(self)} of {self.steps} steps: {self.status}>"

    @property
    def status(self) -> str:
        """That of the first step that is not done; ``interrupted`` where steps are missing."""
        wrong = next((answer.status for answer in self if answer.status != "done"), "done")
        return "interrupted" if wrong == "done" and len(self) < self.steps else wrong

    @property
    def fractions(self) -> Floats:
        """Of moves and loads, of each step [1]."""
        return np.array([answer.fraction for answer in self])

    @property
    def forces(self) -> Floats:
        """On moves (holds where there are none), of each step: array (n, 3) [N]; NaN where a step has no answer."""
        return np.array([_force(answer, "moves") or _force(answer, "holds") or [np.nan] * 3 for answer in self]).reshape(-1, 3)

    def curve(self) -> List[Record]:
        """A record a step that has an answer, with the columns of the command's ``SCENE_METHOD_force.csv``."""
        rows: List[Record] = []
        for step, answer in enumerate(self, start=1):
            if not answer._core.has_displacement:
                continue
            row: Record = {"step": step, "fraction": answer.fraction, "largest_displacement_m": _largest(answer)}
            for name in ("move", "hold"):
                force = _force(answer, name + "s")
                row.update({f"{name}_force_{axis}_n": force[i] if force else None for i, axis in enumerate("xyz")})
            rows.append({**row, "strain_energy_j": answer.strain_energy})
        return rows

    def plot(self, file: Optional[str] = None) -> Any:
        """Force and strain energy over the largest displacement, as a Matplotlib figure; ``file``: .svg or .png, written too."""
        from ._curves import force_figure
        from ._plots import save, style

        points = [(row["largest_displacement_m"], float(np.linalg.norm(self.forces[row["step"] - 1])), row["strain_energy_j"]) for row in self.curve()]
        if not points or not np.isfinite(np.array(points, dtype=float)).all():
            raise ValueError("expected a method that knows forces, and a step that has an answer, found none")
        is_moved = any(answer.moves for answer in self if answer._core.has_displacement)
        scene = self[0].scene
        with style():
            figure = force_figure(scene.title, {self[0].method: points}, "force on " + ("moves" if is_moved else "holds"), "/m" if scene.dimension == 2 else "")
        if file is not None:
            save(figure, file)
        return figure

    def _repr_html_(self) -> str:
        from ._html import rows_html

        return rows_html(repr(self), self.curve())


def _largest(answer: Answer) -> float:
    u = answer._core.displacement
    return float(np.sqrt(np.einsum("...i,...i", u, u).max()))


def _force(answer: Answer, on: str) -> Optional[List[float]]:
    """Sum over all moves, or holds; None without."""
    rows = getattr(answer, on) if answer._core.has_displacement else []
    return [float(sum(row["force"][axis] for row in rows)) for axis in range(3)] if rows else None


def run_steps(scene: "Scene", method: str, steps: int, tolerance: Optional[float], threads: int, seconds: Optional[float],
              bytes: Optional[int], progress: Optional[Tell], frame: str) -> Series:
    """See ``Scene.run``."""
    steps = count("steps", steps)
    series = Series(steps=steps)
    is_fem = method.startswith("fem_")
    course = None if is_fem else _core.Steps(scene._built, method, tolerance)
    for step in range(1, steps + 1):
        fraction = step / steps
        told: Optional[Tell] = None if progress is None else lambda part, what, step=step: progress((step - 1 + part) / steps, what)  # type: ignore[misc]
        try:
            if course is None:
                from . import fem

                core = fem._module().run(scene._built.scaled(fraction), method, threads, seconds, told)
            else:
                core = course.run(fraction, threads, seconds, bytes, told)
            answer = Answer(core, scene, frame, fraction)
            answer.warnings  # need the mechanics, which take as long as a step: Ctrl-C does not wait for all of them
        except KeyboardInterrupt:
            if not series:
                raise
            warnings.warn(f"interrupted after step {step - 1} of {steps}", MailleWarning, stacklevel=3)
            break
        series.append(answer)
    return series


__all__ = ["Series"]
