"""Constants of a model from what was measured: weighted least squares, with intervals of confidence and a refusal
where the data do not determine them.

Unknowns are > 0 and sought by their logarithms. Steps are Gauss and Newton's, by numpy.linalg.lstsq: singular values
below 1e-4 of the greatest count as 0, so that a combination which the data leave open stays where it started
(scipy.optimize.least_squares has no such step: it walks along that combination until its budget is spent). Slopes are
differences of 1 %; a step is halved where the misfit would grow. While the model is far off, steps are taken on
logarithms of the data, in which stiffness is nearly linear. Two other starts, a factor of 4 beside, follow.

Intervals of 95 % come from the linearised model, or from the profile of the misfit where they are wider than 10 %:
normal where sigmas are given, Student's where they are found from the misfit. Both are exact for models that are linear
in the logarithms. Nocedal and Wright 2006, chapter 10; Seber and Wild 1989, section 5.1.
"""

from __future__ import annotations

import csv
import io
import json
import math
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Callable, Dict, Iterable, List, Mapping, NamedTuple, Optional, Sequence, Tuple, Union

import numpy as np

from . import _core
from ._answer import Answer, Floats, Record
from ._faults import Fault, SceneFaults, existing, number_above_0
from ._progress import Progress, Tell, of_command, told
from ._program import UsageError, deliver, in_json, print_safely
from ._scene import FEM_METHODS, PathLike, Scene, Table, _metres, _set
from ._words import in_percent, in_unit, table

_DIFFERENCE = 1e-2  # of logarithms: far above the rounding of the model's algebra
_LEAST_INFLUENCE = 1e-4  # over the greatest, that is more than that rounding
_LONGEST_STEP = 2.3  # a factor of ten
_WIDEST = 4.6  # of logarithms: an interval of a factor of 100 from end to end
_LEAST_SIGMA = float(np.finfo(float).eps)  # over the largest value
_ASSUMED_SIGMA = 0.01  # of each value, where none is given: weights alone
_NEAR = 0.1  # beyond, steps are taken on logarithms of the data
_USUAL_SOLVES = 36  # solves per unknown of a usual fit; scales the progress bar only
_FAR_AWAY = 1.4  # other starts: a factor of 4
_STRAIGHT = 0.1  # logarithms over which slopes are taken not to change
_TOLERANCE_OF_ANSWERS = 1e-7  # far below what a step of the search looks at
_MOST_ROWS, _MOST_IN_JSON = 20, 1000  # images give more data than a reader can use

Model = Callable[[Floats], Optional[Sequence[float]]]


@dataclass
class Identified:
    """One unknown."""

    name: str
    value: float  #: in ``unit``
    interval: Optional[Tuple[float, float]] = None  #: of 95 %; None where nothing tells how exact the data are
    is_determined: bool = True  #: by the data
    start: float = math.nan  #: what the scene has
    unit: str = ""  #: as the scene has it; empty: SI, or none


class Observation(NamedTuple):
    """One measured number: a column of ``[[measure]]``, or a component of a displacement."""

    column: str
    value: float  #: SI
    sigma: Optional[float] = None  #: standard deviation, > 0, SI
    unit: str = ""
    line: int = 0  #: of the file
    fraction: float = 1.0  #: of moves and loads, at which it was measured


@dataclass
class Identification:
    """What ``identify`` found."""

    status: str = "done"  #: or undetermined, budget_reached, interrupted, failed
    message: str = ""  #: why it is not done
    unknowns: List[Identified] = field(default_factory=list)
    observations: List[Observation] = field(default_factory=list)
    computed: List[float] = field(default_factory=list)  #: a number an observation, with the values that were found
    misfit: float = 0.0  #: sum of squared residuals over their sigmas
    degrees_of_freedom: int = 0  #: observations less unknowns
    sigma_is_known: bool = False  #: else it is a part of each value, found from the misfit
    solves: int = 0
    scenes: List[Scene] = field(default_factory=list)  #: with the values that were found

    def __getitem__(self, name: str) -> Identified:
        return next(one for one in self.unknowns if one.name == name)

    def __str__(self) -> str:
        return _in_words(self)


class _Point:
    """Logarithms of the unknowns, the numbers of the model there, and its slopes where they were taken."""

    def __init__(self, theta: Floats, slopes: Optional[Floats] = None) -> None:
        self.theta, self.slopes = theta, slopes
        self.computed = np.empty(0)
        self.misfit = math.inf


class Search:
    """See the head of this file. ``model`` says None where it has no answer; KeyboardInterrupt ends with the best so far."""

    def __init__(self, unknowns: Sequence[Tuple[str, float]], observations: Sequence[Observation], model: Model,
                 tolerance: float = 1e-4, solves_per_unknown: int = 12, tell: Optional[Tell] = None) -> None:
        self._names = [name for name, _ in unknowns]
        self._model, self._tolerance, self._solves_per_unknown, self._tell = model, tolerance, solves_per_unknown, tell
        self._wanted = np.array([one.value for one in observations])
        # A value of zero says something, too: beside the others.
        least = 1e-3 * np.abs(self._wanted).max()
        self._sigma = np.array([_ASSUMED_SIGMA * max(abs(one.value), least) if one.sigma is None else one.sigma
                                for one in observations])
        self._n = len(unknowns)
        self._best = _Point(np.log([start for _, start in unknowns]))
        self._others: List[_Point] = []
        self._found = Identification(degrees_of_freedom=len(observations) - self._n, observations=list(observations),
                                     sigma_is_known=observations[0].sigma is not None)

    def run(self) -> Identification:
        try:
            if not self._evaluate(self._best):
                return self._ended("failed", "the model has no answer at the start")
            status = self._descend(self._best)
            if status == "failed":
                values = ", ".join(f"{name} = {math.exp(t):.4g}" for name, t in zip(self._names, self._best.theta))
                return self._ended(status, "the model has no answer beside " + values)
            if status == "budget_reached":
                return self._finished(status, f"{self._found.solves} solves did not bring the steps below {self._tolerance:g}")
            self._start_elsewhere()
            return self._finished(status, "")
        except KeyboardInterrupt:
            return self._ended("interrupted", "stopped")

    def _evaluate(self, point: _Point) -> bool:
        if self._tell is not None:
            misfit = f", misfit {self._best.misfit:.3g}" if self._best.computed.size else ""
            self._tell(min(1.0, self._found.solves / (_USUAL_SOLVES * self._n)), f"{self._found.solves} answers{misfit}")
        self._found.solves += 1
        numbers = self._model(np.exp(point.theta))
        if numbers is None:
            return False
        point.computed = np.asarray(numbers, dtype=float)
        point.misfit = float((((point.computed - self._wanted) / self._sigma) ** 2).sum())
        return bool(np.isfinite(point.computed).all())

    def _descend(self, point: _Point, fixed: Optional[int] = None) -> str:
        """Steps to the least misfit. ``fixed`` an unknown that stays as it is"""
        budget = self._found.solves - 1 + self._solves_per_unknown * self._n
        while self._found.solves + self._n + 1 <= budget:
            slopes = np.zeros((len(self._wanted), self._n))
            for j in range(self._n):
                if j == fixed:
                    continue
                beside = _Point(point.theta + _DIFFERENCE * np.eye(self._n)[j])
                if not self._evaluate(beside):
                    return "failed"
                slopes[:, j] = (beside.computed - point.computed) / _DIFFERENCE
            point.slopes = slopes
            step = self._step(point, slopes)
            # Else nothing nearer lies that way: the noise of the model's own algebra.
            if np.abs(step).max() < self._tolerance or not self._advance(point, step):
                return "done"
        return "budget_reached"

    def _step(self, point: _Point, slopes: Floats) -> Floats:
        """The least-squares step of the linearised model, the shortest where it is not determined; at most a factor of ten."""
        wanted, computed, weight = self._wanted, point.computed, 1 / self._sigma
        off = wanted - computed
        if (computed * wanted > 0).all() and np.abs(np.log(computed / wanted)).max() > _NEAR:
            off = np.abs(wanted) * np.log(wanted / computed)  # d(log f) = df / f, weighed by the relative sigma
            step = np.linalg.lstsq((weight * np.abs(wanted) / computed)[:, None] * slopes, weight * off, _LEAST_INFLUENCE)[0]
        else:
            step = np.linalg.lstsq(weight[:, None] * slopes, weight * off, _LEAST_INFLUENCE)[0]
        scaled: Floats = step * min(1.0, _LONGEST_STEP / max(np.abs(step).max(), 1e-300))
        return scaled

    def _advance(self, point: _Point, step: Floats) -> bool:
        """Goes as far along the step as the misfit falls. @return False where it falls nowhere"""
        for halvings in range(5):
            ahead = _Point(point.theta + step / 2**halvings)
            if self._evaluate(ahead) and ahead.misfit < point.misfit:
                point.theta, point.computed, point.misfit = ahead.theta, ahead.computed, ahead.misfit
                return True
        return False

    def _start_elsewhere(self) -> None:
        """Takes the best of what other starts lead to, and keeps the others."""
        for sign in (1.0, -1.0):
            for part in (1.0, 0.5, 0.25):
                other = _Point(self._best.theta + sign * part * _FAR_AWAY * (-1.0) ** np.arange(self._n))
                if self._evaluate(other):
                    if self._descend(other) == "done" and other.misfit < self._best.misfit:
                        self._best, other = other, self._best
                    self._others.append(other)
                    break

    def _ended(self, status: str, message: str) -> Identification:
        found = self._found
        found.status, found.message = status, message
        found.unknowns = [Identified(name, math.exp(t), None, False) for name, t in zip(self._names, self._best.theta)]
        if self._best.computed.size:
            found.computed, found.misfit = self._best.computed.tolist(), self._best.misfit
        return found

    def _profile(self, j: int, along: Floats, reach: float, rise: float) -> float:
        """How far unknown ``j`` can go until the least misfit beside it has risen by so much; a straight model says ``reach``.

        Args:
            along: the change of all unknowns with it, of a straight model
        """
        sign, low, high = along[j], 0.0, math.inf
        for _ in range(5):
            if low >= _WIDEST:
                break
            point = _Point(self._best.theta + reach * along)
            point.theta[j] = self._best.theta[j] + reach * sign
            if not self._evaluate(point):  # constants that are none, or no answer: ends of what can be
                high = reach
                reach = (low + high) / 2
                continue
            if self._n > 1:
                self._descend(point, j)
            rose = point.misfit - self._best.misfit
            if abs(rose / rise - 1) < 0.2:
                return reach
            low, high = (reach, high) if rose < rise else (low, reach)
            reach *= math.sqrt(rise / max(rose, rise / 9))
            if not low < reach < high:
                reach = (low + high) / 2 if math.isfinite(high) else 3 * low
        return max(reach, low)

    def _finished(self, status: str, message: str) -> Identification:
        """Intervals, and what the data leave open."""
        from scipy.special import ndtri, stdtrit

        found, best = self._ended(status, message), self._best
        if best.slopes is None:
            return found
        is_normal = found.sigma_is_known or found.degrees_of_freedom == 0
        quantile = float(ndtri(0.975) if is_normal else stdtrit(found.degrees_of_freedom, 0.975))
        scale = 1.0 if is_normal else math.sqrt(found.misfit / found.degrees_of_freedom)
        exact = max(scale, 1e-6)  # exact data tell as much as the model's own rounding lets them
        _, singular, directions = np.linalg.svd(best.slopes / self._sigma[:, None], full_matrices=False)
        open_: List[str] = []
        for s, along in zip(singular, directions):
            if not (s > _LEAST_INFLUENCE * singular[0] and quantile * exact / s <= _WIDEST / 2):
                open_.append(self._left_open(along))
        spread = directions.T * (exact / np.maximum(singular, 1e-100))
        covariance = spread @ spread.T
        is_settled = not open_ and status == "done"
        # As well: to the data's error, at least to 1 % of what is assumed.
        as_well = best.misfit + (quantile * max(exact, 0.01)) ** 2
        for j, one in enumerate(found.unknowns):
            low = high = quantile * math.sqrt(covariance[j, j])
            along = covariance[:, j] / covariance[j, j]
            if is_settled and low <= _WIDEST / 2 and low * np.abs(along).max() > _STRAIGHT:
                rise = (quantile * exact) ** 2
                high, low = self._profile(j, along, high, rise), self._profile(j, -along, low, rise)
            one.is_determined = status == "done" and low + high <= _WIDEST
            if (found.sigma_is_known or found.degrees_of_freedom > 0) and low + high < 700:
                one.interval = (math.exp(best.theta[j] - low), math.exp(best.theta[j] + high))
            if not one.is_determined and is_settled:
                open_.append(one.name + ": values that differ by a factor of 100 fit them")
            for other in self._others:
                off = other.theta[j] - best.theta[j]
                if one.is_determined and other.misfit <= as_well and abs(off) > max(high if off > 0 else low, _STRAIGHT):
                    one.is_determined = False
                    open_.append(f"{one.name}: {math.exp(other.theta[j]):.4g} fits as well")
        if open_ and status == "done":
            found.status, found.message = "undetermined", "the data do not determine " + ", nor ".join(open_)
        return found

    def _left_open(self, along: Floats) -> str:
        """A direction of logarithms along which the data stay as they are."""
        names = [name for name, part in zip(self._names, along) if abs(part) > 0.1]
        if len(names) == 1:
            return names[0] + ": a change of it changes them by less than they are off"
        return " and ".join(names) + " one by one: changed together they leave the data as they are"


# ---- unknowns of scenes ----------------------------------------------------------------------------------------


def constants_in(words: Sequence[str]) -> List[Tuple[str, str]]:
    """Pairs of constant and material of ``E_fibre``, ``E_cross of muscle/soleus`` and keys of a scene, whose material is empty.

    What stands before an ``of`` and has no material of its own is of that one.
    """
    found: List[Tuple[str, str]] = []
    for word in words:
        constant, _, material = word.partition(" of ")
        found.append((constant.strip(" "), material.strip(" ")))
        for before in range(len(found) - 2, -1, -1):
            if not material or found[before][1] or "." in found[before][0]:
                break
            found[before] = (found[before][0], found[-1][1])
    return found


def _table_of(material: Record, constant: str) -> Table:
    """A tissue of the library as a table that says the same."""
    table: Table = {"name": material["name"], "density": f"{material['density']!r} kg/m^3"}
    E, nu, G = material["E"], material["nu"], material["G"]
    if constant in ("youngs_modulus", "poisson_ratio"):
        if not material["is_isotropic"]:
            raise LookupError("one of E_fibre, E_cross, G_fibre, nu_fibre, nu_cross")
        table.update(youngs_modulus=f"{E[0]!r} Pa", poisson_ratio=nu[0])
    elif material["is_isotropic"]:
        raise LookupError("youngs_modulus or poisson_ratio")
    else:
        table.update(E_fibre=f"{E[0]!r} Pa", E_cross=f"{E[1]!r} Pa", G_fibre=f"{G[0]!r} Pa", nu_fibre=nu[0], nu_cross=nu[2])
    table.update((key, material[key]) for key in ("stretch", "compress", "shear") if key in material)
    return table


def _tables_of(document: Table, constant: str, material: str) -> List[Table]:
    """The tables in [specimen] that hold the constants of a material; a name of the library becomes one."""
    specimen = document.get("specimen", {})
    tables = []
    for parent, key in [(specimen, "material"), *((specimen.get("labels", {}), key) for key in specimen.get("labels", {}))]:
        item = parent.get(key)
        entry = _core.material(material) if item == material else None
        if entry is not None:
            item = parent[key] = _table_of(entry, constant)
        if isinstance(item, dict) and item.get("name") == material:
            if constant not in item:
                raise LookupError("a constant that stands in its table")
            tables.append(item)
    return tables


def _found_key(document: Table, key: str) -> Tuple[Any, str]:
    """What stands at a dotted key, or None; and how far it leads."""
    place: Any = document
    last = ""
    for step in re.sub(r"\[([1-9]\d*)\]", lambda found: f".{int(found.group(1)) - 1}", key).split("."):
        if isinstance(place, list) and step.isdigit() and int(step) < len(place):
            place, last = place[int(step)], f"{last}[{int(step) + 1}]"
        elif isinstance(place, dict) and step in place:
            place, last = place[step], f"{last}.{step}" if last else step
        else:
            return None, last
    return place, last


def _described(node: Any) -> str:
    return "a table" if isinstance(node, dict) else "a list" if isinstance(node, list) else json.dumps(node, default=str)


def _number_with_unit(node: Any) -> Optional[Tuple[float, str]]:
    if isinstance(node, str):
        found = re.match(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)(.*)\Z", node)
        return (float(found.group(1)), found.group(2).strip(" \t")) if found else None
    return (float(node), "") if isinstance(node, (int, float)) and not isinstance(node, bool) else None


class _ChangedScene:
    """A scene whose unknowns take other values."""

    def __init__(self, scene: Scene, constants: Sequence[Tuple[str, str]]) -> None:
        self._scene = scene.with_values({})
        self._constants = constants
        self.starts: List[Optional[Tuple[float, str]]] = []
        self.refusals: List[str] = []
        for constant, material in constants:
            node = self._node(constant, material)
            number = _number_with_unit(node)
            if node is not None and not (number and number[0] > 0 and math.isfinite(number[0])):
                self.refusals.append(f'unknown: expected a number > 0 at "{constant}", found {_described(node)}')
                number = None
            self.starts.append(number)

    def _node(self, constant: str, material: str) -> Any:
        if not material:
            node, last = _found_key(self._scene._document, constant)
            if node is None:
                leads = f'"{last}" and no further' if last else "nothing"
                self.refusals.append("unknown: expected keys of the scene such as specimen.material.youngs_modulus, or constants of its "
                                     f'materials such as "E_fibre, E_cross of muscle/soleus", found "{constant}", which leads to {leads}')
            return node
        try:
            tables = _tables_of(self._scene._document, constant, material)
        except LookupError as wanted:
            self.refusals.append(f'unknown: expected of {material} {wanted.args[0]}, found "{constant}"')
            return None
        if not tables:
            self.refusals.append("unknown: expected the name of a material in [specimen], of the library or that a table has as `name`, "
                                 f'found "{material}"')
        return tables[0][constant] if tables else None

    def with_values(self, values: Iterable[float]) -> Scene:
        varied = self._scene.with_values({})
        for (constant, material), start, number in zip(self._constants, self.starts, values):
            if start is None:
                continue
            value = f"{float(number)!r} {start[1]}" if start[1] else float(number)
            if material:
                for table in _tables_of(varied._document, constant, material):
                    table[constant] = value
            else:
                _set(varied._document, constant, value)
        return varied


# ---- what was measured -----------------------------------------------------------------------------------------


def _raise_if_any(faults: Sequence[Fault]) -> None:
    if faults:
        raise SceneFaults("\n".join(str(fault) for fault in faults), faults)


def read_observations(text: str, file: str, units: Mapping[str, str]) -> List[Observation]:
    """Reads CSV with the columns ``measure``, ``value`` and, if wanted, ``sigma`` and ``fraction`` (of moves and loads): in SI, or with a unit.

    Args:
        units: of the columns that there are, by name: ``N``, ``m``, ...

    Raises:
        SceneFaults: every fault
    """
    wanted_head = "a first line of the columns measure, value and, if wanted, sigma and fraction"
    faults: List[Fault] = []
    head: List[str] = []
    found: List[Observation] = []
    lines = ["" if line.lstrip().startswith("#") else line for line in text.lstrip("\ufeff").splitlines()]
    records = csv.reader(lines)

    def number(cell: str, column: str, unit: str) -> float:
        value = _core.quantity(cell, unit)
        rule = {"value": "", "sigma": ", > 0", "fraction": ", above 0 and at most 1"}[column]
        if value is None or (rule and not 0 < value <= (1 if column == "fraction" else math.inf)):
            faults.append(Fault(file, records.line_num, column, _core.quantity_in_words(unit) + rule, f'"{cell}"'))
        return math.nan if value is None else value

    try:
        for cells in records:
            cells = [cell.strip() for cell in cells]
            line = records.line_num
            if not cells or cells == [""]:
                continue
            if not head:
                head = cells
                if head[:2] != ["measure", "value"] or head[2:] not in ([], ["sigma"], ["fraction"], ["sigma", "fraction"]):
                    _raise_if_any([Fault(file, line, "", wanted_head, ",".join(head))])
            elif not 2 <= len(cells) <= len(head):
                faults.append(Fault(file, line, "", f"{len(head)} cells", str(len(cells))))
            elif cells[0] not in units:
                faults.append(Fault(file, line, "measure", "a measure of the scene: " + ", ".join(units), f'"{cells[0]}"'))
            else:
                unit, row = units[cells[0]], dict(zip(head, cells))
                fraction = number(row["fraction"], "fraction", "") if row.get("fraction") else 1.0
                if any((one.column, one.fraction) == (cells[0], fraction) for one in found):
                    faults.append(Fault(file, line, "measure", "every measure once", f'"{cells[0]}" again'))
                value = number(cells[1], "value", unit)
                sigma = number(row["sigma"], "sigma", unit) if row.get("sigma") else None
                found.append(Observation(cells[0], value, sigma, unit, line, fraction))
    except csv.Error as error:
        faults.append(Fault(file, records.line_num, "", "comma-separated values", str(error)))
    for one in found:
        if (one.sigma is None) != (found[0].sigma is None):
            faults.append(Fault(file, one.line, "sigma", "of every line, or of none", "none where the first line has one"
                                if one.sigma is None else "one where the first line has none"))
    if not head:
        faults.append(Fault(file, 1, "", wanted_head, "an empty file"))
    elif not found and not faults:
        faults.append(Fault(file, 0, "", "at least one measured number", "none"))
    _raise_if_any(faults)
    return found


class _Measures:
    """What ``[[measure]]`` tables say: columns of a table, or a mapping from columns to values or (value, sigma)."""

    def __init__(self, scene: Scene, measured: Union[str, Mapping[str, Any]], file: str) -> None:
        units = dict(_core.measure_columns(scene._built))
        if not units:
            raise UsageError("SCENE: expected [[measure]] tables, which say what was measured, found none")
        if not isinstance(measured, str):
            rows = ["measure,value,sigma"]
            rows += [",".join(map(str, (name, *(value if isinstance(value, (tuple, list)) else (value,))))) for name, value in measured.items()]
            measured, file = "\n".join(rows), "measured"
        self.observations = read_observations(measured, file, units)
        self.fractions = sorted({one.fraction for one in self.observations})

    def computed(self, answers: Mapping[float, Answer]) -> List[float]:
        numbers: Dict[Tuple[float, str], Any] = {}
        for fraction, answer in answers.items():
            for row in answer._core.measures():
                numbers[fraction, row["name"]] = row["value"]
                numbers.update(((fraction, f"{row['name']}_{axis}"), value) for axis, value in zip("xyz", row["vector"] or ()))
        found = (numbers.get((one.fraction, one.column)) for one in self.observations)
        return [math.nan if number is None else number for number in found]


class _Displacements:
    """Displacements of points or of voxels, in the world of the body [m]."""

    fractions = [1.0]

    def __init__(self, scene: Scene, file: str, sigma: Optional[float]) -> None:
        if _core.is_image_file(file) and sigma is None:
            _raise_if_any([Fault(file, 0, "", '--sigma: how exact the image\'s displacements are, e.g. "0.1 mm"', "an image alone")])
        seen = _core.seen_displacements(scene._built, file)
        if seen["not_finite"]:
            _raise_if_any([Fault(file, 0, "", "a number in every voxel of the body", f"none in {seen['not_finite']} of them")])
        faults = []
        self.observations: List[Observation] = []
        d = scene.dimension
        own = np.where(np.isnan(seen["sigmas"]), math.nan if sigma is None else sigma, seen["sigmas"])
        for name, line, place, vector, of_point, is_in in zip(seen["names"], seen["lines"], seen["places"], seen["vectors"], own, seen["is_in_body"]):
            if not is_in:
                x, y, z = place
                faults.append(Fault(file, line, "x", "a point of the body at rest, in its world", f"({x:.6g}, {y:.6g}, {z:.6g}) m, where there is no matter"))
            if math.isnan(of_point):
                faults.append(Fault(file, line, "sigma", "a column `sigma`, or --sigma", "neither"))
            self.observations += [Observation(f"{name}_{axis}", float(u), float(of_point), "m", line) for axis, u in zip("xyz"[:d], vector)]
        _raise_if_any(faults)
        if not self.observations:
            _raise_if_any([Fault(file, 0, "", "displacements of the body at rest, in its world", "none of them where there is matter")])
        at = (np.linalg.inv(scene.node_affine) @ np.column_stack([seen["places"], np.ones(len(seen["places"]))]).T)[:d]
        self._at = np.where(np.abs(at - np.round(at)) < 1e-4, np.round(at), at)[::-1]  # what a viewer shows on a border is on it

    def computed(self, answers: Mapping[float, Answer]) -> List[float]:
        from scipy.ndimage import map_coordinates

        u = answers[1.0].displacement
        numbers = [map_coordinates(np.ascontiguousarray(u[..., b]), self._at, order=1, mode="nearest") for b in range(len(self._at))]
        return list(np.stack(numbers, axis=-1).ravel())


def _is_table_of_points(text: str) -> bool:
    """By its first row: columns ``x``, ``ux``, ... in place of ``measure``."""
    first = text.partition("\n")[0]
    return "ux" in first and "measure" not in first


Measured = Union[PathLike, Mapping[str, Any]]


def _data_of(scene: Scene, measured: Measured, sigma: Optional[float]) -> Union[_Measures, _Displacements]:
    if isinstance(measured, Mapping):
        return _Measures(scene, measured, "")
    file = existing(measured)
    if _core.is_image_file(file):
        return _Displacements(scene, file, sigma)
    text = Path(file).read_bytes().decode("utf-8", "replace")
    if _is_table_of_points(text):
        return _Displacements(scene, file, sigma)
    if sigma is not None:
        raise UsageError("sigma: expected an image or points of displacements with it, found a table of measures, which has a column of its own")
    return _Measures(scene, text, file)


def _answer(scene: Scene, method: str, threads: int, fraction: float) -> Answer:
    """What the method says once that fraction of moves and loads is done."""
    core = scene._built if fraction == 1 else scene._built.scaled(fraction)
    if method in FEM_METHODS:
        from . import fem

        return Answer(fem._module().run(core, method, threads, None, None), scene)
    own = scene._document.get("relaxation", {}).get("tolerance", 1.0)
    return Answer(core.run(method, min(own, _TOLERANCE_OF_ANSWERS), threads, None, None, None), scene)


def identify(scene: Union[Scene, Sequence[Scene]], measured: Union[Measured, Sequence[Measured]], unknown: Sequence[str],
             method: str = "coupled", *, sigma: Union[float, str, None] = None, threads: int = 1, progress: Progress = None) -> Identification:
    """Finds constants at which ``method`` says what was measured, with intervals of 95 %: as ``maille fit --measured``.

    The result has status, message, unknowns (name, value, interval, is_determined), computed, misfit and the fitted ``scenes``.
    Cost  some 36 answers an unknown. Ctrl-C: the best so far, status ``interrupted``.

    Args:
        scene: a Scene, or several with their data together
        measured: of each scene a file, or a mapping from columns of ``[[measure]]`` to a value or (value, sigma)
        unknown: keys of scenes, or ``"E_cross of muscle/soleus"``; > 0, sought from the values that scenes have
        method: coupled, relaxed, fem_q1 or fem_q2
        sigma: of displacements of an image or of points: "0.1 mm", or metres
        progress: as of ``Scene.run``; its fraction is of that cost

    Raises:
        ValueError: a faulty argument
        SceneFaults: every fault of the data
    """
    scenes = [scene] if isinstance(scene, Scene) else list(scene)
    files = [measured] if isinstance(measured, (str, Mapping, Path)) else list(measured)  # type: ignore[arg-type]
    if len(files) != len(scenes) or not scenes:
        raise UsageError(f"measured: expected data of each of {len(scenes)} scenes, found {len(files)}")
    try:
        deviation = None if sigma is None else number_above_0("sigma", _metres(sigma), '"0.1 mm"')
    except ValueError:
        raise UsageError(f'sigma: expected a length > 0 such as "0.1 mm", found "{sigma}"') from None
    constants = constants_in([unknown] if isinstance(unknown, str) else unknown)
    names = [f"{constant} of {material}" if material else constant for constant, material in constants]
    if not names or len(set(names)) < len(names):
        raise UsageError(f"unknown: expected constants, each once, found {', '.join(names) or 'none'}")
    data = [_data_of(one, file, deviation) for one, file in zip(scenes, files)]
    changed = [_ChangedScene(one, constants) for one in scenes]
    starts = []
    for i, name in enumerate(names):
        known = [one.starts[i] for one in changed if one.starts[i]]
        if not known:
            raise UsageError(changed[0].refusals[0])
        if len({start[1] for start in known if start}) > 1:
            raise UsageError(f"unknown: expected one unit of {name} in all scenes, found several")
        starts.append(known[0] or (0.0, ""))
    observations = [one._replace(column=f"{scene.name}: {one.column}") if len(scenes) > 1 else one
                    for scene, part in zip(scenes, data) for one in part.observations]
    if len(observations) < len(names):
        raise UsageError(f"measured: expected at least as many numbers as there are unknowns, {len(names)}, found {len(observations)}")
    largest: Dict[str, float] = {}
    for seen in observations:
        largest[seen.unit] = max(largest.get(seen.unit, 0), abs(seen.value))
    for seen in observations:  # squares of 1 / sigma have to be numbers
        least = max(1e-100, _LEAST_SIGMA * largest[seen.unit])
        if seen.sigma is not None and seen.sigma < least:
            raise UsageError(f"measured: expected a sigma of {least:.2g} or more, the rounding of the largest value, found {seen.sigma:g} of {seen.column}")
    if all(one.value == 0 and one.sigma is None for one in observations):
        raise UsageError("measured: expected a number that is not 0, or sigmas, found zeros alone")
    refusals: List[str] = []

    def model(values: Floats) -> Optional[List[float]]:
        numbers: List[float] = []
        try:
            for one, part in zip(changed, data):
                varied, answers = one.with_values(values), {}
                for fraction in part.fractions:
                    answer = answers[fraction] = _answer(varied, method, threads, fraction)
                    if not answer.is_converged:
                        refusals.append(f"{answer.status}: {answer.message}")
                        return None
                numbers += part.computed(answers)
        except SceneFaults as error:
            refusals.append(str(error))
            return None
        return numbers

    with told(progress) as tell:
        found = Search([(name, start) for name, (start, _) in zip(names, starts)], observations, model, tell=tell).run()
    if found.status == "failed" and refusals:
        found.message += ": " + refusals[-1]
    for one, (start, unit) in zip(found.unknowns, starts):
        one.start, one.unit = start, unit
    found.scenes = [one.with_values([each.value for each in found.unknowns]) for one in changed]
    return found


# ---- the command -----------------------------------------------------------------------------------------------


def _in_words(found: Identification) -> str:
    def interval(one: Identified) -> str:
        return "  -" if one.interval is None else f"  {one.interval[0]:.4g} to {one.interval[1]:.4g} {one.unit}"

    text = table([("unknown", -36, lambda one: one.name), ("start", 12, lambda one: f"{one.start:.4g}"),
                  ("value", 12, lambda one: f"{one.value:.5g}"), ("  interval of 95 %", 0, interval)], found.unknowns) + "\n"
    rows = [(one, found.computed[i] if i < len(found.computed) else math.nan) for i, one in enumerate(found.observations)]
    if len(rows) > _MOST_ROWS:  # the worst first
        rows.sort(key=lambda row: -math.inf if math.isnan(row[1]) else -abs(row[1] - row[0].value) / (row[0].sigma or 1))
    text += table([("measure", -20, lambda row: row[0].column + (f" at {row[0].fraction:g}" if row[0].fraction != 1 else "")),
                   ("measured", 14, lambda row: in_unit(row[0].value, row[0].unit)),
                   ("computed", 14, lambda row: None if math.isnan(row[1]) else in_unit(row[1], row[0].unit)),
                   ("off by", 10, lambda row: in_percent(row[1] / row[0].value - 1) if row[0].value else None)], rows[:_MOST_ROWS])
    if len(rows) > _MOST_ROWS:
        text += f"the {_MOST_ROWS} of {len(rows)} data that are furthest off\n"
    text += f"\n{found.solves} solves, {found.status}{': ' if found.message else ''}{found.message}\n"
    if found.sigma_is_known and found.degrees_of_freedom > 0:
        text += (f"misfit {found.misfit:.3g} with {found.degrees_of_freedom} degrees of freedom: about 1 each where model and "
                 "sigmas are right\n")
    elif not found.sigma_is_known and found.degrees_of_freedom > 0:
        text += "no sigma in the file: intervals take what is left for the error of the data, alike in per cent\n"
    elif not found.sigma_is_known:
        text += "as many data as unknowns, and no sigma: nothing tells how sure the values are\n"
    return text


def _in_json(found: Identification, scenes: Sequence[Scene], method: str) -> Record:
    low_high = [one.interval or (None, None) for one in found.unknowns]
    return {
        "scene": scenes[0].name, **({} if len(scenes) == 1 else {"scenes": [one.name for one in scenes]}),
        "method": method, "status": found.status, "message": found.message, "solves": found.solves,
        "misfit": found.misfit, "degrees_of_freedom": found.degrees_of_freedom, "sigma_is_known": found.sigma_is_known,
        "unknowns": [{"unknown": one.name, "unit": one.unit, "start": one.start, "value": one.value, "low": low, "high": high,
                      "is_determined": one.is_determined} for one, (low, high) in zip(found.unknowns, low_high)],
        "observations": [{"measure": one.column, "unit": one.unit, "measured": one.value, "sigma": one.sigma,
                          "computed": found.computed[i] if i < len(found.computed) else None,
                          **({} if one.fraction == 1 else {"fraction": one.fraction})}
                         for i, one in enumerate(found.observations[:_MOST_IN_JSON])]}


def main(request: Record) -> int:
    """``maille fit SCENES --measured FILES``: the request has its options."""
    scenes = [Scene.from_file(one["scene"]) for one in request["measured"]]
    try:
        found = identify(scenes, [one["measured"] for one in request["measured"]], request["unknowns"], request["method"], sigma=request["sigma"],
                         threads=request["threads"], progress=of_command())
    except UsageError as error:
        raise UsageError(re.sub(r"\A(?=unknown:|measured:|sigma:)", "--", str(error))) from None
    files = [one["out"] for one in request["measured"] if one["out"] and found.status == "done"]
    for scene, file in zip(found.scenes, files):  # files first: they stay where nothing can be printed
        scene.save(file, f"Made by maille fit {request['maille']}.", overwrite=True)
    if request["json"]:
        deliver(in_json(_in_json(found, scenes, request["method"])), request["json"])
    if request["json"] != "-":
        print_safely(f"{found}\n" + "".join(f"wrote {file}\n" for file in files))
    return 0 if found.status == "done" else 1


__all__ = ["Identification", "Identified", "identify"]
