"""What follows from the table of a study: summary, sensitivity and pictures.

The command hands over the rows as ``maille study --json`` has them, and the study's *plan*: how its points were
laid out, which decides the estimator. ``NAME_about.json`` beside the table holds the plan too, so that a notebook
needs the table alone.

A *response* is a column of numbers of the table: what pictures and sensitivities are of. Errors are in percent, and
those below 0.001 % count as 0.001 %: of answers that agree to rounding there is nothing to see.
"""

from __future__ import annotations

import json
import math
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

from ._program import deliver, in_json, no_picture, print_safely
from . import _words
from ._words import in_percent, in_seconds, in_unit, upper_median

Row = Dict[str, Any]
Rows = List[Row]

_NORMS = {"relative_l2": "relative_l2", "relative_max": "relative_max", "rms_m": "rms"}
# Column of the table: its place in JSON, its unit, whether it says what the body does.
_COLUMNS: Dict[str, Tuple[Tuple[str, ...], str, bool]] = {
    **{name: (("error", key), "m" if name == "rms_m" else "%", name == "relative_l2") for name, key in _NORMS.items()},
    **{f"{key}_s": (("seconds", key), "s", False) for key in ("setup", "solve", "total")},
    "bytes": (("bytes",), "B", False),
    "iterations": (("iterations",), "", False),
    "limit_violation": (("limit_violation",), "spacings", False),
    "force": (("force",), "N", True),
    "strain_energy": (("strain_energy",), "J", True),
    "test_reaction": (("test", "reaction"), "N", True),
    "test_stiffness": (("test", "stiffness"), "N/m", True),
    "test_apparent_modulus": (("test", "apparent_modulus"), "Pa", True),
    "test_failure": (("test", "failure"), "N", True),
    **{f"reference_{name}": (("reference_error", key), "m" if name == "rms_m" else "%", False) for name, key in _NORMS.items()},
}


class NoPicture(ValueError):
    """There is nothing to draw; the message says why."""


@dataclass
class Response:
    """A column of numbers of the table."""

    name: str
    path: Tuple[str, ...]
    unit: str
    is_error: bool

    @property
    def label(self) -> str:
        name = "L2 error" if self.name == "relative_l2" else self.name
        return f"{name} [{self.unit}]" if self.unit else name

    def value(self, row: Row) -> Optional[float]:
        """In the shown unit; None where the row has no finite number."""
        value: Any = row
        for key in self.path:
            value = value.get(key) if isinstance(value, dict) else None
        if not isinstance(value, (int, float)) or not math.isfinite(value):
            return None
        if self.unit == "%":
            value *= 100
        return max(1e-3 if self.unit == "%" else 0.0, value) if self.is_error else float(value)


def _measure_names(rows: Rows) -> List[str]:
    return list(dict.fromkeys(name for row in rows for name in row.get("measures") or {}))


def response_of(name: str, rows: Rows) -> Response:
    """@param name  a column of the table, or of a measure"""
    if name in _COLUMNS:
        path, unit, _ = _COLUMNS[name]
        return Response(name, path, unit, unit == "%" or name.endswith("rms_m"))
    is_error = name.endswith("_error")
    unit = "%" if is_error else next((units[name] for units in (row.get("measure_units") or {} for row in rows) if name in units), "")
    return Response(name, ("measures", name), unit, is_error)


def mechanical_responses(rows: Rows) -> List[Response]:
    """Those that say what the body does, and the error, without columns that no row has."""
    names = [name for name, (_, _, is_mechanical) in _COLUMNS.items() if is_mechanical] + _measure_names(rows)
    responses = [response_of(name, rows) for name in names]
    return [response for response in responses if any(response.value(row) is not None for row in rows)]


def default_response(rows: Rows) -> str:
    """The result of the scene's [test], else its first measure, else the force on the moved part, else the error."""
    known = {response.name for response in mechanical_responses(rows)}
    measures = [name for name in _measure_names(rows) if not name.endswith("_error")]
    wanted = ["test_apparent_modulus", "test_stiffness", "test_reaction", *measures, "force"]
    return next((name for name in wanted if name in known), "relative_l2")


def _parameter(row: Row, name: str) -> "Union[float, str]":
    value = row["parameters"].get(name)
    return value if isinstance(value, str) else math.inf if value is None else float(value)  # JSON has no infinity


# Sensitivity


def _positions(parameter: Dict[str, Any]) -> Tuple[Callable[[Any], float], Union[None, str, List[float]]]:
    """The position of a value, and the axis as ``by_chaos`` takes it."""
    values: Optional[List[Any]] = parameter.get("values")
    place: Callable[[Any], float] = float
    if values is None:
        begin, end = parameter["range"]
        is_logarithmic = parameter["logarithmic"]
        if parameter.get("normal"):  # mean and deviation, or median and factor
            return lambda value: float(math.log(value / begin) / math.log(end) if is_logarithmic else (value - begin) / end), "normal"
    else:
        shown = [math.inf if value is None else value for value in values]
        if all(isinstance(value, (int, float)) and math.isfinite(value) for value in shown):
            begin, end = min(shown), max(shown)
            is_logarithmic = begin > 0 and end >= 30 * begin
        else:  # texts have no distances: their places in the list
            begin, end, is_logarithmic = 0, len(shown) - 1, False

            def place(value: Any) -> float:
                return float(shown.index(value))

    def position(value: Any) -> float:
        try:
            at = place(value)
            ratio: float = math.log(at / begin) / math.log(end / begin) if is_logarithmic else (at - begin) / (end - begin)
        except (ValueError, ZeroDivisionError):
            return 0.0
        return 2 * ratio - 1 if math.isfinite(ratio) else 0.0

    return position, None if values is None else [position(value) for value in shown]


def sensitivities(rows: Rows, plan: Dict[str, Any]) -> List[Dict[str, Any]]:
    """Sensitivities of every mechanical column and of the error, as ``study --json`` has them.

    @param plan  "combine", "points" (of one scene), "scenes", "methods" and "parameters", each with its "column", and
                 "values" or "range", "logarithmic" and "normal"
    """
    from . import _sensitivity as estimators

    parameters, n_points = plan["parameters"], plan["points"]
    names = [parameter["column"] for parameter in parameters]
    if len(names) < 2 or not rows:
        return []
    axes = [_positions(parameter) for parameter in parameters]
    points = np.zeros((n_points, len(names)))
    for row in rows:
        points[(row["case"] - 1) % n_points] = [position(_parameter(row, name)) for name, (position, _) in zip(names, axes)]

    def found(values: npt.NDArray[np.float64]) -> Any:
        if plan["combine"] == "zip":
            why = "the parameters are zipped: what one does cannot be told from what the others do"
            return estimators.Sensitivity(len(names), undetermined=why)
        if plan["combine"] == "saltelli":
            return estimators.by_pairs(len(names), values)
        if plan["combine"] == "grid" and np.isfinite(values).all():
            return estimators.by_grid([len(parameter["values"]) for parameter in parameters], values)
        return estimators.by_chaos(points, values, [levels for _, levels in axes])

    groups: Dict[Tuple[str, str], Rows] = {(scene, method): [] for scene in plan["scenes"] for method in plan["methods"]}
    for row in rows:
        if (row["scene"], row["method"]) in groups:
            groups[row["scene"], row["method"]].append(row)
    everything = []
    for response in mechanical_responses(rows):
        for (scene, method), of_group in groups.items():
            values = np.full(n_points, np.nan)
            for row in of_group:
                value = response.value(row)
                if value is not None:
                    values[(row["case"] - 1) % n_points] = value
            if np.isfinite(values).any():
                everything.append({"scene": scene, "method": method, "response": response.name, "label": response.label,
                                   **found(values).as_json(names)})  # fmt: skip
    return everything


def read_rows(file: "str | os.PathLike[str]") -> Rows:
    """The rows of a study's table, NAME.jsonl. A writer that is killed tears the last line, which is left out.

    Raises:
        FileNotFoundError: there is no such file
        ValueError: a fault, with its line
    """
    lines = Path(file).read_text(encoding="utf-8", errors="replace").splitlines(keepends=True)
    rows: Rows = []
    for number, line in enumerate(lines, 1):
        try:
            row = json.loads(line)
            if not isinstance(row, dict) or not all(key in row for key in ("study", "case", "scene", "parameters", "method", "status")):
                raise ValueError
            rows.append(row)
        except ValueError:
            if number < len(lines) or line.endswith("\n"):
                raise ValueError(f"{os.fspath(file)}:{number}: expected a row of a study (NAME.jsonl), found another line") from None
    return rows


def sensitivity(table: "str | os.PathLike[str] | Rows", plan: Optional[Dict[str, Any]] = None) -> List[Dict[str, Any]]:
    """Sobol's indices: which parameter of a study makes which share [1] of each result's variance, with intervals of 95 %.

    An entry a response, scene and method, as ``study --json`` has it. Cost: with 1000 cases some seconds an entry. Sources:
    Saltelli and others 2010; Sudret 2008.

    Args:
        table: OUT/NAME.jsonl, beside OUT/NAME_about.json; or its rows
        plan: of rows: what OUT/NAME_about.json has under "plan"

    Raises:
        ValueError: another kind of file, or no plan
    """
    if not isinstance(table, list):
        file = Path(table)
        table = read_rows(file)
        about = file.with_name(file.stem + "_about.json")
        if plan is None and about.is_file():
            plan = json.loads(about.read_text(encoding="utf-8")).get("plan")
    if plan is None:
        raise ValueError("sensitivity: expected the plan of the study, as NAME_about.json beside its table has it, found none")
    return sensitivities(table, plan)


def design(table: "str | os.PathLike[str] | Rows", response: str = "", scene: str = "",
           method: str = "") -> Tuple[List[str], npt.NDArray[np.float64], npt.NDArray[np.float64]]:  # fmt: skip
    """Names, points (n, d) and values (n) of a study for other programs: ``openturns.Sample(points)``; for files ``numpy.savetxt``.

    Default: ``default_response`` of the first row's scene by the first method with values.

    Raises:
        ValueError: a parameter that is text, or no values
    """
    rows = table if isinstance(table, list) else read_rows(table)
    column = response_of(response or default_response(rows), rows)
    known = [row for row in rows if column.value(row) is not None and row["scene"] == (scene or rows[0]["scene"])]
    known = [row for row in known if row["method"] == (method or known[0]["method"])]
    names = list(known[0]["parameters"]) if known else []
    points = [[_parameter(row, name) for name in names] for row in known]
    if not known or any(isinstance(value, str) for point in points for value in point):
        raise ValueError(f"design: expected numbers of parameters and of {column.name}, found {'texts' if known else 'none'}")
    return names, np.array(points, float), np.array([column.value(row) for row in known], float)


# Words


def sensitivity_in_words(found: Sequence[Dict[str, Any]], response: str) -> str:
    """A table of one response; empty without."""

    def index(key: str) -> Callable[[Row], str]:
        def words(row: Row) -> str:
            low, high = row[key + "_low"], row[key + "_high"]
            return f"{row[key]:.3f}" if low == high else f"{row[key]:.3f} ({low:.2f} to {high:.2f})"

        return words

    of_it = [one for one in found if one["response"] == response]
    if not of_it:
        return ""
    lines = [{**one, **row} for one in of_it if not one["undetermined"] for row in one["parameters"]]
    text = f"Sobol indices of {of_it[0]['label']}: shares of its variance, intervals of 95 %\n"
    if lines:
        text += _words.table([("scene", -14, lambda row: row["scene"]), ("method", -9, lambda row: row["method"]),
                       ("parameter", -30, lambda row: row["parameter"]), ("alone", 24, index("first")),
                       ("with others", 24, index("total"))], lines)  # fmt: skip
    for one in of_it:
        by = f"undetermined: {one['undetermined']}" if one["undetermined"] else f"by {one['estimator']}, {one['samples']} samples"
        text += f"{one['scene']}, {one['method']}: {by}"
        text += f", {one['left_out']} without a value left out" if one["left_out"] else ""
        text += f", {100 * one['unexplained']:.2g} % of the variance unexplained" if not one["undetermined"] and one["unexplained"] else ""
        text += "\n"
    return text + "\n"


def _measures_in_words(rows: Rows) -> str:
    """A line a measure and method: least, median and largest value over the cases, median error."""
    names, lines = _measure_names(rows), []
    for name in names:
        if f"{name}_error" not in names:  # a component of a vector, or an error
            continue
        unit = response_of(name, rows).unit
        for method in dict.fromkeys(row["method"] for row in rows):
            of_method = [row.get("measures") or {} for row in rows if row["method"] == method]
            values, errors = ([of[key] for of in of_method if of.get(key) is not None] for key in (name, f"{name}_error"))
            if values:
                lines.append([name, method, *(in_unit(value, unit) for value in (min(values), upper_median(values), max(values))),
                              in_percent(upper_median(errors)) if errors else None])  # fmt: skip
    headings = [("measure", -16), ("method", -9), ("least", 13), ("median", 13), ("largest", 13), ("error", 10)]
    if all(line[5] is None for line in lines):
        headings.pop()
    return _words.table([(heading, width, lambda line, i=i: line[i]) for i, (heading, width) in enumerate(headings)], lines) if lines else ""  # type: ignore[misc]


def summary(rows: Rows) -> str:
    """A line a method with its errors and seconds over the cases, then what failed."""

    def is_converged(row: Row) -> bool:
        return row["status"] in ("done", "clamped")

    has_forces = any(row.get("force") is not None for row in rows)
    headings = ("cases", 6), ("settled", 8), ("least L2 %", 13), ("median L2 %", 13), ("largest L2 %", 13), ("median time", 12)
    lines = []
    for method in dict.fromkeys(row["method"] for row in rows):
        of = [row for row in rows if row["method"] == method]
        errors = [100 * row["error"]["relative_l2"] for row in of if (row.get("error") or {}).get("relative_l2") is not None]
        seconds = [row["seconds"]["total"] for row in of if row["status"] not in ("refused", "failed")]
        forces = [row["force"] for row in of if row.get("force") is not None]
        of_errors = [f"{value:.3g}" for value in (min(errors), upper_median(errors), max(errors))] if errors else ["-"] * 3
        lines.append([method, str(len(of)), str(sum(map(is_converged, of))), *of_errors,
                      in_seconds(upper_median(seconds)) if seconds else "-",
                      f" {min(forces):.4g} to {max(forces):.4g}" if forces else ""])  # fmt: skip
    text = ""
    for cells in [["method", *(heading for heading, _ in headings), " force on moves [N]" if has_forces else ""], *lines]:
        text += " ".join([f"{cells[0]:<9}", *(f"{cell:>{width}}" for cell, (_, width) in zip(cells[1:], headings)), cells[7]]).rstrip() + "\n"
    measures = _measures_in_words(rows)
    text += ("\n" + measures if measures else "") + "\n"
    doubtful = sum(row["timing"] != "alone" for row in rows)
    if doubtful:
        text += f"seconds of {doubtful} of {len(rows)} rows were taken beside other work\n"
    failed = [f"{row['method']} {row['status']}" + (f": {row['message']}" if row["message"] else "") for row in rows if not is_converged(row)]
    return text + "".join(f"{failed.count(reason)} x {reason}\n" for reason in sorted(set(failed)))


# Pictures: maps over two parameters, else curves over each. All plots of a picture have one scale.


def _spans_decades(values: Sequence[float]) -> bool:
    return min(values) > 0 and max(values) >= 30 * min(values)


def _varied(rows: Rows, parameters: Optional[Sequence[str]]) -> Dict[str, bool]:
    """Parameters that have several values, and whether some are texts."""
    varied = {}
    for name in (rows[0]["parameters"] if parameters is None else parameters) if rows else ():
        values = {_parameter(row, name) for row in rows}
        if len(values) > 1:
            varied[name] = any(isinstance(value, str) for value in values)
    return varied


def _is_grid(points: Dict[Tuple[float, float], float]) -> bool:
    n_x, n_y = (len({point[axis] for point in points}) for axis in (0, 1))
    return n_x > 2 and n_y > 2 and len(points) == n_x * n_y


def _is_spread(points: Dict[Tuple[float, float], float]) -> bool:
    """Whether points lie about in the plane: not on a line that rises or falls, as zipped parameters do."""
    y = [point[1] for point in sorted(points)]
    is_function = len({point[0] for point in points}) == len(points)
    return len(points) >= 9 and not (is_function and (y == sorted(y) or y == sorted(y, reverse=True)))


def _maps(rows: Rows, response: Response, names: Sequence[str]) -> Dict[Tuple[str, str], Dict[Tuple[float, float], float]]:
    maps: Dict[Tuple[str, str], Dict[Tuple[float, float], float]] = {}
    for row in rows:
        value = response.value(row)
        if value is not None:
            x, y = (_parameter(row, name) for name in names)
            maps.setdefault((row["scene"], row["method"]), {})[x, y] = value  # type: ignore[index]
    return {key: points for key, points in maps.items() if _is_grid(points) or _is_spread(points)}


def _draw_maps(maps: Any, names: Sequence[str], label: str, title: str) -> Any:
    from matplotlib.colors import LogNorm, Normalize
    from matplotlib.ticker import LogLocator, MaxNLocator

    from ._plots import GREY, log_axis, new_figure

    across = min(3, len(maps))
    down = -(-len(maps) // across)
    figure, axes = new_figure(4 * across + 2, 0.8 + 3.2 * down, f"{title}: {label}", down, across, sharex=True, sharey=True)
    values = [value for points in maps.values() for value in points.values()]
    least, most = min(values), max(values)
    is_log = _spans_decades(values)
    norm = LogNorm(least, most) if is_log else Normalize(least, most if most > least else least + max(abs(least), 1e-30))
    levels = LogLocator(subs=(1,) if most > 3e3 * least else (1, 2, 5)) if is_log else MaxNLocator(7, steps=[1, 2, 5, 10])
    levels = [level for level in levels.tick_values(least, most) if least < level < most]
    for axis, ((scene, method), points) in zip(axes.flat, maps.items()):
        x, y = (sorted({point[i] for point in points}) for i in (0, 1))
        if _is_grid(points):
            z = np.array([[points[at, height] for at in x] for height in y])
            drawn = axis.pcolormesh(x, y, z, norm=norm, shading="gouraud", rasterized=True)
            if levels:
                axis.clabel(axis.contour(x, y, z, levels=levels, colors="white", linewidths=0.9), fmt="%g", fontsize=8)
            axis.grid(False)
        else:  # between cases that lie anyhow nothing is known: a point each, in its colour
            at = np.array(list(points))
            drawn = axis.scatter(at[:, 0], at[:, 1], c=list(points.values()), norm=norm, edgecolors=GREY, linewidths=0.5)
        axis.set(title=f"{scene}, {method}", xlabel=names[0])
        for which, on_axis in (("x", x), ("y", y)):
            if _spans_decades(on_axis):
                log_axis(axis, which)
    for first in axes[:, 0]:
        first.set_ylabel(names[1])
    for axis in axes.flat[len(maps) :]:
        axis.set_visible(False)
    figure.colorbar(drawn, ax=axes, label=label, ticks=levels or None, format="%g")
    return figure


def _draw_curves(rows: Rows, varied: Dict[str, bool], response: Response, title: str) -> Any:
    """A plot a scene and parameter. Of numbers a curve a method through medians in a band from the least to the most of
    the cases that share a value; of texts a bar; points alone where no two cases share one."""
    from ._plots import log_axis, look, new_figure

    plots: Dict[Tuple[str, str], Dict[str, Dict[Union[float, str], List[float]]]] = {}
    for row in rows:
        value = response.value(row)
        for name in varied if value is not None else ():
            at = _parameter(row, name)
            at = f"{at:g}" if varied[name] and not isinstance(at, str) else at
            plots.setdefault((row["scene"], name), {}).setdefault(row["method"], {}).setdefault(at, []).append(value)  # type: ignore[arg-type]
    plots = {key: lines for key, lines in plots.items() if any(len(line) > 1 for line in lines.values())}
    if not plots:
        return None
    across = min(3, len(plots))
    down = -(-len(plots) // across)
    figure, axes = new_figure(4 * max(2, across), 0.8 + 3 * down, f"{title}: {response.label}", down, across, sharey=True)
    handles: Dict[str, Any] = {}
    everything: List[float] = []
    for axis, ((scene, name), lines) in zip(axes.flat, plots.items()):
        is_text = varied[name]
        places = list(dict.fromkeys(at for line in lines.values() for at in line))
        is_scattered = len(varied) > 1 and not is_text and all(len(of) == 1 for line in lines.values() for of in line.values())
        for number, (method, line) in enumerate(lines.items()):
            how = {**look(method), "markersize": 7.5 if number == 0 else 5}  # of two that agree the first looks out from behind
            ats = list(line) if is_text else sorted(line, key=float)
            x = [places.index(at) + 0.14 * (number - (len(lines) - 1) / 2) for at in ats] if is_text else ats
            middle, low, high = ([upper_median(line[at]) for at in ats], [min(line[at]) for at in ats], [max(line[at]) for at in ats])
            everything += low + high
            if low != high and is_text:
                axis.vlines(x, low, high, color=how["color"], linewidth=2.5)
            elif low != high:
                axis.fill_between(x, low, high, color=how["color"], alpha=0.15, linewidth=0)
            handles.setdefault(method, axis.plot(x, middle, linestyle="none" if is_text or is_scattered else "-", **how)[0])
        axis.set(title=scene, xlabel=name)
        if is_text:
            axis.set_xticks(range(len(places)), [str(place) for place in places])
        elif _spans_decades(places):  # type: ignore[arg-type]
            log_axis(axis, "x")
    if _spans_decades(everything) or response.unit == "%":
        for axis in axes.flat:
            log_axis(axis, "y")
    for first in axes[:, 0]:
        first.set_ylabel(response.label)
    for axis in axes.flat[len(plots) :]:
        axis.set_visible(False)
    axes[0, 0].legend(handles=list(handles.values()))
    return figure


def study_figure(rows: Rows, title: str, column: str = "", parameters: Optional[Sequence[str]] = None) -> Any:
    """A picture of one response of a study over what was varied, as a Matplotlib figure.

    Two parameters on a whole grid: a map a scene and method, with lines of equal value; on points that lie anyhow a
    coloured point a case. Else a plot a scene and parameter, see docs/study.md.
    @param column  of the table, or of a measure; empty: ``default_response``
    @param parameters  columns of the axes; None: of all parameters, formulas too

    Raises:
        NoPicture: there is nothing to draw
    """
    from ._plots import style

    response, varied = response_of(column or default_response(rows), rows), _varied(rows, parameters)
    with style():
        maps = _maps(rows, response, list(varied)) if len(varied) == 2 and not any(varied.values()) else {}
        figure = _draw_maps(maps, list(varied), response.label, title) if maps else _draw_curves(rows, varied, response, title)
    if figure is None:
        raise NoPicture("no parameter has errors at several values" if response.name == "relative_l2"
                        else f"no parameter has `{response.name}` at several values")  # fmt: skip
    return figure


# The command


def finish(request: Dict[str, Any]) -> int:
    """``maille study`` and ``study merge --study`` once the table is written. @return the exit code"""
    document, plan = request["document"], request["plan"]
    rows: Rows = document["rows"]
    is_interrupted = document.get("interrupted", False)  # then it ends soon
    found = sensitivities(rows, plan) if plan and not is_interrupted else []
    deliver(in_json({**request["about"], "plan": plan, "sensitivity": found}), request["about_file"])
    of_response = sensitivity_in_words(found, default_response(rows))
    if request["kind"] == "merge":
        print_safely(f"wrote {request['about_file']}\n" + of_response)
        return int(request["exit_code"])
    if request["json"] != "-":
        print_safely(request["head"] + summary(rows) + of_response + request["notes"])
    if request["json"]:
        deliver(in_json({**document, "sensitivity": found}), request["json"])
    if request["picture"] and not _drawn(request, rows):
        return 1
    return int(request["exit_code"])


def _drawn(request: Dict[str, Any], rows: Rows) -> bool:
    if request["document"]["interrupted"]:
        no_picture("the study is not whole", request["picture"], is_kept=True)
        return False
    from ._plots import save

    try:
        names = [parameter["column"] for parameter in request["plan"]["parameters"]] if request["plan"] else None  # no formulas
        save(study_figure(rows, request["document"]["title"], request["picture_of"], names), request["picture"])
    except (NoPicture, OSError) as error:
        no_picture(str(error), request["picture"])
        return False
    if request["json"] != "-":
        print_safely(f"wrote {request['picture']}\n")
    return True
