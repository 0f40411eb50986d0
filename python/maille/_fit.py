"""Which neighbour limits, or weights of ``relaxed``, of one material or several come nearest to a reference over a
family of scenes.

The mean over the scenes of the squared relative L2 error is minimised, among limits that let every move through whole:
a cut costs more than any error. Numbers are sought by their logarithms. An answer of ``limits`` consists of minima over
paths, so errors have kinks, a wall where limits begin to cut (the best limits of a pulled bar lie right at it), and no
known derivatives. That requires methods without derivatives: scipy.optimize.differential_evolution with a fixed seed for
each material's part of each component, then Nelder and Mead's simplex (Nelder-Mead) for all numbers of a component, from
fresh simplices that get smaller, since a simplex may come to rest beside a kink. The result is good, not proven to be
the best; ``at_least`` is a bound that no numbers pass. Same input, same bits.
"""

from __future__ import annotations

import json
import math
import operator
from dataclasses import dataclass, field
from typing import Any, Callable, Dict, Iterable, List, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from . import _core, _toml
from ._answer import Answer, Floats, Record
from ._identify import main as _identify_main
from ._progress import Progress, Tell, of_command, told
from ._program import UsageError, deliver, in_json, print_safely, refuse_foreign, write_whole
from ._scene import PathLike, Scene
from ._words import Column, in_percent, table

_SEED = 20250607  # any; the same in every run
_RANGE = math.log(1e2)  # slack and weights are sought from the start over this to the start times this
_JUST_ABOVE = 1 + 1e-6  # exactly taut limits may cut a move back by rounding
_PRICE_OF_A_CUT = 10.0  # what a move that is cut back wholly adds to the mean of squares, whose worst is about 1
_SAME_ERROR = 1e-9  # below this part of the error, two errors are the same
_WORTH_SAYING = 0.01
_OUT_OF_THE_WAY = [2.0, 2, 2, 0, 0, 0, 0, 1, 1, 1, 0, 1, 1, 1, 0]  # limits that no small strain reaches

class _Over(Exception):
    """The trials are used up."""


class _Case:
    """A scene and what is aimed at there."""

    def __init__(self, scene: Scene, reference: Floats) -> None:
        self.scene = scene
        self.core = _core.FitCase(scene._built, np.ascontiguousarray(reference).ravel())
        self.materials = self.core.materials()
        self.record = self.core.record()
        if not self.record["moves"]:
            raise UsageError(f"{scene.name}: expected a scene in which nodes are free and move, found none")

    def error(self, method: str, limits: str, rows: Floats, threads: int) -> Tuple[str, str, Tuple[float, float, float], float]:
        return self.core.error(method, limits, rows, threads)

    def norm(self, method: str, limits: str, threads: int) -> Optional[float]:
        """Within its own limits or within taut ones; None where the method has no answer."""
        status, _, component, _ = self.error(method, limits, np.empty((0, 18)), threads)
        return None if status in ("refused", "failed") else math.hypot(*component)


class _Parameters:
    """The numbers that a fit looks for, as logarithms: slack and weights are positive, and matter by their ratio.

    A row a material: stretch (3), compress (3), shear by rows (9), relaxed weights (3). Starts at taut limits, at the one
    scale at which every move of the family comes through, or at weights of 1.
    """

    def __init__(self, cases: Sequence[_Case], method: str) -> None:
        self.materials: Dict[str, Record] = {}
        for case in cases:
            self.materials.update((record["name"], record) for record in case.materials if record["name"] not in self.materials)
        d = cases[0].scene.dimension
        out_of_the_way = _OUT_OF_THE_WAY if method == "relaxed" else [1.0] * 6 + [0.0] * 9
        self._base: Floats = np.array([out_of_the_way + list(record["relaxed_weights"]) for record in self.materials.values()], dtype=np.float64)
        self.names: List[Tuple[str, str]] = []
        places: List[Tuple[int, int, int, int]] = []  # material, column, component, sign of the slack
        starts: List[float] = []
        if method == "limits":
            scale = max(case.core.taut_scale() for case in cases) * _JUST_ABOVE
            if not scale > 0:
                raise UsageError("nothing to fit limits to: no scene moves one part of the body against another")
        for m, (material, record) in enumerate(self.materials.items()):
            for b in range(d):
                if method == "relaxed":
                    parts = [(f"relaxed_weights[{'xyz'[b]}]", 15 + b, 0, 1.0)]
                else:
                    axial, shear = scale * record["axial_compliance"][b], [scale * row[b] for row in record["shear_compliance"]]
                    parts = [(f"stretch[{'xyz'[b]}]", b, 1, axial), (f"compress[{'xyz'[b]}]", 3 + b, -1, axial),
                             *((f"shear[{'xyz'[a]}][{'xyz'[b]}]", 6 + 3 * a + b, 0, shear[a]) for a in range(d) if a != b)]
                for name, column, sign, start in parts:
                    self.names.append((material, name))
                    places.append((m, column, b, sign))
                    starts.append(start)
        self._material, self._column, self._component, self._sign = np.array(places).T
        # A link that is compressed to nothing has used all of its slack, 1.
        most = np.where(self._sign < 0, 0.0, np.log(starts) + _RANGE)
        self.start = np.minimum(np.log(starts), most)
        self.low, self.high = self.start - _RANGE, np.minimum(self.start + _RANGE, most)
        # Along the grid's axes a component knows its own numbers and no others.
        whole = [np.arange(len(starts))]
        if all(case.record["is_along_grid"] and case.record["is_along_x"] for case in cases):
            whole = [np.flatnonzero(self._component == b) for b in range(d) if any(case.record["is_driven"][b] for case in cases)]
        self.blocks = whole
        self.blocks_of_materials = [block[self._material[block] == m] for block in whole for m in range(len(self.materials))]

    def values(self, x: Floats) -> Floats:
        """As files have them: ratios to the rest length, or weights."""
        positive = np.exp(x)
        values: Floats = np.where(self._sign == 0, positive, 1 + self._sign * positive)
        return values

    def rows(self, x: Floats) -> Floats:
        rows = self._base.copy()
        rows[self._material, self._column] = self.values(x)
        return rows

    def rows_of(self, case: _Case, rows: Floats) -> Floats:
        names = list(self.materials)
        return rows[[names.index(record["name"]) for record in case.materials]]


class _Search:
    def __init__(self, cases: Sequence[_Case], parameters: _Parameters, method: str, threads: int, trials: int,
                 progress: Optional[Tell]) -> None:
        self._cases, self._parameters, self._method, self._threads = cases, parameters, method, threads
        self._budget, self._progress = trials, progress
        self.status = "done"
        self.trials = 0
        self.best, self.best_value, self.is_feasible = parameters.start, math.inf, False

    def evaluate(self, x: Floats) -> float:
        """Mean of squares of errors; infeasible numbers pay for what they cut. Remembers the best."""
        rows = self._parameters.rows(x)
        total, is_whole = 0.0, True
        for case in self._cases:
            status, message, component, cut = case.error(self._method, "given", self._parameters.rows_of(case, rows), self._threads)
            if status in ("refused", "failed"):
                raise RuntimeError(f"{case.scene.name}: {self._method}: {message}")
            total += component[0] ** 2 + component[1] ** 2 + component[2] ** 2 + _PRICE_OF_A_CUT * cut
            is_whole = is_whole and status == "done"
        self.trials += 1
        value = total / len(self._cases)
        if (is_whole and not self.is_feasible) or (is_whole == self.is_feasible and value < self.best_value):
            self.best, self.best_value, self.is_feasible = x.copy(), value, is_whole
        if self._progress is not None:
            self._progress(min(1.0, self.trials / self._budget), f"of at most {self._budget} trials, error {100 * math.sqrt(self.best_value):.4g} %")
        return value

    def _objective(self, block: npt.NDArray[np.int64]) -> Callable[[Floats], float]:
        whole = self.best.copy()

        def of_part(part: Floats) -> float:
            if self.trials >= self._budget:
                raise _Over
            whole[block] = np.clip(part, self._parameters.low[block], self._parameters.high[block])
            return self.evaluate(whole)

        return of_part

    def _bounds(self, block: npt.NDArray[np.int64]) -> List[Tuple[float, float]]:
        low = np.minimum(self._parameters.low[block], self.best[block])
        return list(zip(low, np.maximum(self._parameters.high[block], self.best[block])))

    def _globally(self, block: npt.NDArray[np.int64]) -> None:
        from scipy.optimize import differential_evolution

        low, high = np.array(self._bounds(block)).T
        inside = low + np.clip((self.best[block] - low) / (high - low), 1e-12, 1 - 1e-12) * (high - low)  # rounding may not pass an end
        differential_evolution(self._objective(block), list(zip(low, high)), x0=inside, seed=_SEED, popsize=10, maxiter=40, tol=0,
                               atol=1e-9, mutation=(0.4, 0.9), recombination=0.8, polish=False)

    def _locally(self, block: npt.NDArray[np.int64], step: float) -> None:
        from scipy.optimize import minimize

        n, start, bounds = len(block), self.best[block], self._bounds(block)
        simplex = np.vstack([start, start + step * np.eye(n)])
        for i, (_, high) in enumerate(bounds):
            if simplex[i + 1, i] > high:
                simplex[i + 1, i] = start[i] - step
        minimize(self._objective(block), start, method="Nelder-Mead", bounds=bounds,
                 options={"initial_simplex": simplex, "maxfev": 400 * n, "maxiter": 400 * n, "xatol": 1e-8, "fatol": math.inf, "adaptive": True})

    def run(self, start: Floats) -> None:
        self.best = start
        try:
            x = start.copy()
            self.evaluate(x)
            for _ in range(12):
                if self.is_feasible:
                    break
                x = np.minimum(x + math.log(2.0), self._parameters.high)
                self.evaluate(x)
            for block in self._parameters.blocks_of_materials:
                self._globally(block)
            for step in (0.5, 0.125, 0.03, 0.008, 0.002):
                before = self.best_value
                for block in self._parameters.blocks:
                    self._locally(block, step)
                if step < 0.1 and before - self.best_value <= _SAME_ERROR * before:
                    break
        except _Over:
            self.status = "budget_reached"
        except KeyboardInterrupt:
            self.status = "interrupted"


@dataclass
class Fit:
    """What ``fit`` found; ``str()`` is the command's table, ``record()`` its JSON, ``save`` writes the material's file."""

    method: str
    reference: str
    status: str  #: done, clamped (no limits let every move through), budget_reached or interrupted: the best so far
    trials: int  #: of the family
    materials: List[Record] = field(default_factory=list)  #: name, limits, relaxed_weights
    numbers: List[Record] = field(default_factory=list)  #: material, name, value, determined, at_end_of_range
    fitted: List[Record] = field(default_factory=list)  #: a row a scene, see docs/fit.md
    held_out: List[Record] = field(default_factory=list)
    reasons: List[str] = field(default_factory=list)  #: what to know about it, in words
    _files: List[Record] = field(default_factory=list, repr=False)

    @property
    def relative_l2(self) -> float:
        """Root mean square of the errors of fitted scenes."""
        return _mean(self.fitted, "relative_l2") or 0.0

    def record(self) -> Record:
        def family(rows: List[Record]) -> Record:
            return {**{key: _mean(rows, key) for key in ("relative_l2", "taut", "at_least")}, "scenes": rows}

        return {"method": self.method, "reference": self.reference, "status": self.status, "trials": self.trials, "materials": self.materials,
                "numbers": self.numbers, "fitted": family(self.fitted), "held_out": family(self.held_out), "reasons": self.reasons}

    def __str__(self) -> str:
        text = f"{self.method} fitted to {self.reference}: {self.status}, {self.trials} trials\n\n"
        material = ""
        for number in self.numbers:
            if len(self.materials) > 1 and number["material"] != material:
                text += ("\n" if material else "") + number["material"] + "\n"
            material = number["material"]
            note = ("   (not determined: no answer of the family depends on it here)" if not number["determined"]
                    else "   (at the end of the range that was searched)" if number["at_end_of_range"] else "")
            text += f"  {number['name']:<18} {number['value']:.6g}{note}\n"
        headings = [("L2 error", -26), ("status", -10), *((name, 9) for name in ("before", "taut", "now", "of x", "of y", "of z", "alone", "at least"))]
        columns: List[Column] = [(name, width, operator.itemgetter(i)) for i, (name, width) in enumerate(headings)]
        text += "\n" + table(columns, [])
        for title, rows in (("fitted to", self.fitted), ("not fitted to", self.held_out)):
            if rows:
                cells = [("  " + row["scene"], row["status"], *map(in_percent, (row["before"], row["taut"], row["relative_l2"], *row["components"],
                                                                               row["alone"], row["at_least"]))) for row in rows]
                means = [in_percent(_mean(rows, key)) for key in ("taut", "relative_l2", "at_least")]
                cells.append(("  root mean square", " ", " ", *means[:2], " ", " ", " ", " ", means[2]))
                text += title + "\n" + table(columns, cells).partition("\n")[2]
        return text + ("\nwhat to know about it\n" if self.reasons else "") + "".join(f"  {reason}\n" for reason in self.reasons)

    def save(self, file: PathLike, version: str = "", *, overwrite: bool = False) -> None:
        """Writes what a scene names by ``material = "FILE.toml"``, or of several by ``"FILE.toml#NAME"``; numbers are whole."""
        from pathlib import Path

        def names(rows: List[Record]) -> str:
            return ", ".join(row["scene"] for row in rows)

        notes = [f"Made by maille fit {version}: {self.method} against {self.reference}, {self.status}.".replace(" :", ":"),
                 f"Fitted to {names(self.fitted)}: {in_percent(self.relative_l2)} off.",
                 f"Not fitted to {names(self.held_out)}: {in_percent(_mean(self.held_out, 'relative_l2'))} off." if self.held_out
                 else "No scene was kept from the fit.",
                 "Limits are along the materials' axes; axis 1 is the fibre." if self.method == "limits"
                 else "Only the weights are fitted: the limits stand where no small strain comes."]
        is_one = len(self._files) == 1
        refuse_foreign(file, overwrite)
        table = self._files[0] if is_one else {one["name"]: one for one in self._files}
        write_whole(Path(file), "".join("# " + "".join(c if c.isprintable() else "?" for c in note) + "\n" for note in notes) + _toml.dumps(table))


def _mean(rows: Sequence[Record], key: str) -> Optional[float]:
    """Root of the mean of squares; None where a row has none."""
    values = [row[key] for row in rows]
    return None if None in values else math.sqrt(sum(value**2 for value in values) / len(values)) if values else 0.0


def _without_influence(search: _Search, best: Floats, value: float, changed: Callable[[float, int], float]) -> Floats:
    """Changes each number that no answer depends on."""
    for i in range(len(best)):
        x = best.copy()
        x[i] = changed(x[i], i)
        if abs(search.evaluate(x) - value) <= _SAME_ERROR * value:
            best = x
    return best


def _decides(search: _Search, parameters: _Parameters, best: Floats, value: float, i: int) -> bool:
    """Whether twice or half of a number changes any answer that counts."""
    for step in (math.log(0.5), math.log(2.0)):
        x = best.copy()
        x[i] = min(x[i] + step, max(parameters.high[i], best[i]))
        if abs(search.evaluate(x) - value) > _SAME_ERROR * value:
            return True
    return False


def _row(case: _Case, rows: Floats, alone: Optional[float], method: str, threads: int) -> Record:
    status, message, component, _ = case.error(method, "given", rows, threads)
    if status in ("refused", "failed"):
        raise RuntimeError(f"{case.scene.name}: {method}: {message}")
    floor = case.core.unreachable()
    return {"scene": case.scene.name, "status": status, "before": case.norm(method, "own", threads), "taut": case.norm(method, "taut", threads),
            "relative_l2": math.hypot(*component), "components": list(component), "alone": alone, "at_least": math.hypot(*floor),
            "at_least_by_component": list(floor)}


def _beyond_reach(row: Record, case: _Case) -> str:
    """Which components lose something, how much, and whether anything moves them."""
    lost = [(f"{'xyz'[b]} ({100 * part:.3g} %)", case.record["is_driven"][b]) for b, part in enumerate(row["at_least_by_component"]) if part >= _WORTH_SAYING]
    driven, left_alone = (", ".join(text for text, is_driven in lost if is_driven == wanted) for wanted in (True, False))
    texts = []
    if left_alone:
        texts.append(f"nothing moves {left_alone}, which stay 0 whatever the numbers: components do not feel each other, "
                     "so there is no Poisson effect and no bending")
    if driven:
        texts.append(f"the reference moves {driven} beyond everything that is prescribed there, which components for themselves never do")
    return "; ".join(texts)


def _reasons(found: Fit, cases: Sequence[_Case]) -> List[str]:
    """Why the fit is no better: what nothing can reach, turned fibres, one set of limits for several moves."""
    reasons = []
    for row, case in zip(found.fitted, cases):
        if lost := _beyond_reach(row, case):
            reasons.append(f"{row['scene']}: at least {100 * row['at_least']:.3g} % with any numbers: {lost}")
    if not all(case.record["is_along_grid"] for case in cases):
        reasons.append("fibres are turned against the grid: a turned material couples the components, and limits or weights along the "
                       "axes of the grid do not (docs/limits.md)")
    for row in found.fitted:
        if row["alone"] is not None and row["relative_l2"] - row["alone"] > _WORTH_SAYING:
            reasons.append(f"{row['scene']}: alone it would come to {100 * row['alone']:.3g} %, with numbers that serve all scenes it comes to "
                           f"{100 * row['relative_l2']:.3g} %" + ("; limits do not grow with the move, elastic strains do" if found.method == "limits" else ""))
    if found.status == "clamped":
        reasons.append("no limits were found that let every move through: the best of those that cut some back")
    if len(cases) < 3:
        reasons.append(f"fitted to {len(cases)} scene{'' if len(cases) == 1 else 's'}: that few say little about any other; three or more, with "
                       "pulls, bends and pokes among them, are a family")
    if not found.held_out:
        reasons.append("no scene was kept from the fit: how it does on others is not known (--test SCENE, --holdout PART)")
    return reasons


def _fit(cases: Sequence[_Case], tests: Sequence[_Case], method: str, reference: str, trials: int, threads: int,
         progress: Optional[Tell]) -> Fit:
    parameters = _Parameters(cases, method)
    search = _Search(cases, parameters, method, threads, trials, progress)
    search.run(parameters.start)
    status, used = search.status, search.trials
    if status == "done" and not search.is_feasible:
        status = "clamped"
    best, value = search.best, search.best_value
    determined = [True] * len(best)
    alone: List[Optional[float]] = [None] * len(cases)
    try:
        if status != "interrupted":  # what the scenes do not say is left as it was
            best = _without_influence(search, best, value, lambda _, i: float(parameters.start[i]))
            if method == "limits":  # a link that nothing asks about must not bind where another scene pulls at it
                best = _without_influence(search, best, value, lambda x, _: max(x, 0.0))
            determined = [_decides(search, parameters, best, value, i) for i in range(len(best))]
            if len(cases) > 1:
                for i, case in enumerate(cases):
                    of_one = _Search([case], parameters, method, threads, trials, progress)
                    of_one.run(best)
                    if of_one.status == "interrupted":
                        raise KeyboardInterrupt
                    alone[i] = math.sqrt(of_one.best_value)
    except KeyboardInterrupt:
        status, alone = "interrupted", [None] * len(cases)
    rows = parameters.rows(best)
    found = Fit(method, reference, status, used)
    for record, row in zip(parameters.materials.values(), rows.tolist()):
        limits = {"stretch": row[0:3], "compress": row[3:6], "shear": [row[6:9], row[9:12], row[12:15]]}
        found.materials.append({"name": record["name"], "limits": limits, "relaxed_weights": row[15:18]})
        kept = {key: record[key] for key in ("name", "density", "E", "nu", "G")}
        file: Record = {**kept, **limits}
        if row[15:18] != [1.0, 1.0, 1.0]:
            file["relaxed_weights"] = row[15:18]
        if "damage" in record:
            file["damage"] = record["damage"]
        found._files.append(file)
    ends = (best - parameters.low < 1e-3) | (parameters.high - best < 1e-3)
    found.numbers = [{"material": material, "name": name, "value": float(number), "determined": is_determined,
                      "at_end_of_range": bool(is_determined and at_end)}
                     for (material, name), number, is_determined, at_end in zip(parameters.names, parameters.values(best), determined, ends)]
    found.fitted = [_row(case, parameters.rows_of(case, rows), one, method, threads) for case, one in zip(cases, alone)]
    found.held_out = [_row(case, parameters.rows_of(case, rows), None, method, threads) for case in tests]
    found.reasons = _reasons(found, cases)
    return found


def _refuse(fitted: Sequence[Scene], tests: Sequence[Scene], method: str) -> None:
    """What cannot be fitted, before anything is answered."""
    known: Dict[str, Record] = {}
    for number, scene in enumerate((*fitted, *tests)):
        case = _core.FitCase(scene._built, np.zeros(scene._built.dimension * int(np.prod(scene.nodes))))
        if scene.dimension != fitted[0].dimension:
            raise UsageError(f"{scene.name}: expected the dimension of {fitted[0].name}, {fitted[0].dimension}, found {scene.dimension}")
        if case.record()["has_loads"] and method == "limits":
            raise UsageError(f"{scene.name}: expected moves alone: limits carry no loads, found a load")
        if case.record()["contracts"]:
            raise UsageError(f"{scene.name}: expected fibres that do not pull: relaxed carries no contraction, found a contraction")
        for record in case.materials():
            if number >= len(fitted) and record["name"] not in known:
                raise UsageError(f"{scene.name}: expected materials that scenes to fit to have, too, found {record['name']}")
            same = known.setdefault(record["name"], record)
            if any(same[key] != record[key] for key in ("E", "nu", "G")):
                raise UsageError(f"{scene.name}: expected the constants that {record['name']} has in the other scenes, or another name, found others")


def fit(scenes: Iterable[Scene], tests: Iterable[Scene] = (), *, method: str = "limits", reference: Union[str, Sequence[Any]] = "fem_q2",
        trials: int = 20000, threads: int = 1, progress: Progress = None) -> Fit:
    """Finds the limits, or weights of ``relaxed``, of all materials of a family that come nearest to a reference: as ``maille fit``.

    The result has status, numbers, materials, fitted, held_out and reasons; ``str`` is the command's table, ``save`` writes the material.
    Cost  some thousand answers of each scene. Ctrl-C: the best so far, status ``interrupted``.

    Args:
        scenes: of one dimension; a material is known by its name
        tests: measured, never fitted to
        method: limits or relaxed
        reference: a method that answers each scene, or best, the finest finite elements that a minute affords, by the command; or of each
            scene and test an Answer, or an array like its displacement [m]
        trials: of the family, at most
        progress: as of ``Scene.run``

    Raises:
        ValueError: scenes without moves
        RuntimeError: a reference that fails
    """
    if method not in ("limits", "relaxed"):
        raise UsageError(f"method: expected limits or relaxed, found {method!r}")

    fitted, held_out = list(scenes), list(tests)
    given = [] if isinstance(reference, str) else list(reference)
    if reference == "best":
        return _by_command(fitted, held_out, method, trials, threads, progress)
    if not fitted or (given and len(given) != len(fitted) + len(held_out)):
        raise UsageError(f"scenes: expected at least one, and a reference of each, found {len(fitted) + len(held_out)} and {len(given)}")

    _refuse(fitted, held_out, method)

    def case(number: int, scene: Scene) -> _Case:
        answer = given[number] if given else scene.run(str(reference), threads=threads)
        if isinstance(answer, Answer):
            if not answer.is_converged:
                raise RuntimeError(f"{scene.name}: the reference {answer.method} ended {answer.status}: {answer.message}")
            answer = answer._core.displacement
        return _Case(scene, np.moveaxis(np.asarray(answer, dtype=float), -1, 0))

    every = [case(number, scene) for number, scene in enumerate(fitted + held_out)]
    cases, others = every[: len(fitted)], every[len(fitted):]
    with told(progress) as tell:
        return _fit(cases, others, method, "given" if given else str(reference), trials, threads, tell)


def _by_command(fitted: Sequence[Scene], held_out: Sequence[Scene], method: str, trials: int, threads: int, progress: Progress) -> Fit:
    """``maille fit --reference best``: the meshes of ``best`` are the command's."""
    import tempfile
    import tomllib
    from pathlib import Path

    from ._command import run, scene_files

    with tempfile.TemporaryDirectory() as temporary, told(progress) as tell:
        files = scene_files([*fitted, *held_out], temporary)
        out = Path(temporary) / "material.toml"
        words = ["fit", *files[: len(fitted)], *(word for test in files[len(fitted):] for word in ("--test", test)), "--method", method, "--reference", "best",
                 "--trials", str(trials), "--threads", str(threads), "--out", str(out), "--json", "-"]
        ended = run(words, tell)
        if not out.is_file():
            if ended.is_interrupted:
                raise KeyboardInterrupt
            raise (RuntimeError if ended.code == 1 else UsageError)(ended.complaint or f"maille fit ended with exit code {ended.code}")
        record, table = json.loads(ended.output), tomllib.loads(out.read_text("utf-8"))
    return Fit(**{key: record[key] for key in ("method", "reference", "status", "trials", "materials", "numbers", "reasons")},
               fitted=record["fitted"]["scenes"], held_out=record["held_out"]["scenes"],
               _files=[table] if "name" in table else list(table.values()))


def main(request: Record) -> int:
    """``maille fit``: the request has its options, and files of references."""
    if "measured" in request:
        return _identify_main(request)
    if "family" in request:
        scenes, tests = ([Scene.from_file(file) for file in files] for files in request["family"])
        _refuse(scenes, tests, request["method"])
        return 0
    fitted, held_out = ([_Case(Scene.from_file(one["scene"]), np.fromfile(one["reference"])) for one in request[group]] for group in ("fitted", "held_out"))
    with told(of_command()) as tell:
        found = _fit(fitted, held_out, request["method"], request["reference"], request["trials"], request["threads"], tell)
    is_quiet = request["json"] == "-"
    if request["out"]:  # files first: they stay where nothing can be printed
        found.save(request["out"], request["maille"], overwrite=True)
    if request["json"]:
        deliver(in_json({"maille": request["maille"], **found.record()}), request["json"])
    if not is_quiet:
        print_safely(f"{found}\n" + (f"wrote {request['out']}\n" if request["out"] else ""))
    return 0 if found.status == "done" else 1


__all__ = ["Fit", "fit"]
