"""The section of what `maille compare --out` or `maille run --out` wrote: measures, mechanics by part, errors, costs.

Methods are told apart by name. Of a run in steps each method's last row counts. Figures of parts are held against
the same part's by the reference: its own are no error, and have a dash. Pictures of bodies come with the request:
the command draws them from the files for ParaView.
"""

from __future__ import annotations

from functools import partial
from typing import Any, Callable, Dict, List, Optional, Tuple

from ._report_parts import (NONE, Data, Series, Table, asked, at, cell, clean, distinct, figure_cell, in_bytes, largest_of, length, listed, measured,
                            name_as_id, number, pascals, percent, plain, plot, said, seconds, text_cell, words)  # fmt: skip

ERRORS = {"relative_l2": "L2 error", "relative_max": "max error", "force": "force error", "strain_energy": "energy error",
          "strain": "strain error", "stress": "stress error", "recovered_stress": "recovered stress error"}  # fmt: skip
SPREADS: Dict[str, Tuple[str, Callable[[Any], str]]] = {
    "fibre_strain": ("fibre strain", percent), "largest_strain": ("largest strain", percent), "smallest_strain": ("smallest strain", percent),
    "fibre_stress": ("fibre stress", pascals), "von_mises": ("von Mises", pascals), "pressure": ("pressure", pascals)}  # fmt: skip


def _rows_of(results: Any) -> List[Data]:
    """The last row of every method."""
    rows: Dict[str, Data] = {}
    for comparison in listed(results, "results"):
        rows.update((words(row, "method"), row) for row in listed(comparison, "results") if words(row, "method"))
    return list(rows.values())


def measure_columns(rows: List[Data]) -> List[str]:
    return distinct(words(measure, "name") for row in rows for measure in listed(row, "measures") if words(measure, "name"))


def measure_cells(rows: List[Data], row: Data, name: str) -> List[Data]:
    """The value, and its error. @param rows  all of them: rounding beside their largest value is 0"""
    found = next((one for one in listed(row, "measures") if at(one, "name") == name), None)
    unit, value = words(found, "unit"), at(found, "value")
    error = figure_cell(percent, row, "error", "measures", name)
    line = [number(point, "value") for point in listed(found, "line")]
    known = [one for one in line if one is not None]
    if known:
        return [text_cell(f"{measured(min(known), unit)} to {measured(max(known), unit)}"), error]
    if number(value) is None:
        return [cell(words(found, "why_not") or NONE), error]
    largest = largest_of(at(one, "value") for each in rows for one in listed(each, "measures") if at(one, "name") == name)
    return [cell(measured(clean(value, largest), unit), value), error]


def _vector_in_words(measure: Any) -> str:
    vector = listed(measure, "vector")
    largest = largest_of(vector)
    return f"({', '.join(said('.4g')(clean(one, largest)) for one in vector)}) {words(measure, 'unit')}" if vector else ""


def _measures_table(rows: List[Data], reference: str, name: str) -> Table:
    table = Table(name + "-measures", "What the scene asks for by name")
    table.add("measure", "method", is_number=False)
    table.add("value")
    if reference:
        table.add("error", why="relative, against " + reference)
    table.add("vector", is_number=False, why="x, y and z of the world")
    for measure in measure_columns(rows):
        for row in rows:
            found = next((one for one in listed(row, "measures") if at(one, "name") == measure), None)
            if found is not None:
                cells = measure_cells(rows, row, measure)[: 2 if reference else 1]
                table.append([text_cell(measure), text_cell(row["method"]), *cells, text_cell(_vector_in_words(found))], row["method"] == reference)
    return table


def _parts_of(row: Data) -> List[Data]:
    """Labels where the body has some, else materials; and the whole body where those are several."""
    mechanics = at(row, "mechanics")
    parts = listed(mechanics, "labels") or listed(mechanics, "materials")
    body = at(mechanics, "body")
    return parts + [body] if isinstance(body, dict) and len(parts) != 1 else parts


def _name_of_part(part: Data) -> str:
    label = number(part, "label")
    return f"{plain(label)} {words(part, 'material')}" if label is not None else words(part, "material") or "whole body"


def _largest_figure(part: Data, is_strain: bool) -> float:
    return largest_of(at(part, key, end) for key in SPREADS if key.endswith("strain") == is_strain for end in ("min", "max"))


def _spread_cell(part: Data, key: str) -> Data:
    """The mean, by which the table sorts, and the middle 90 %."""
    show, largest = SPREADS[key][1], _largest_figure(part, key.endswith("strain"))
    mean, low, high = (show(clean(at(part, key, which), largest)) for which in ("mean", "p5", "p95"))
    return cell(f"{mean} ({low} to {high})" if NONE not in (mean, low, high) else mean, at(part, key, "mean"))


def _error_cell(value: Any, wanted: Any) -> Data:
    if number(value) is None or not number(wanted):
        return cell(NONE)
    error = clean(abs(value / wanted - 1), 1)
    return cell(percent(error), error)


def _parts_table(rows: List[Data], reference: str, dimension: int, name: str) -> Table:
    table = Table(name + "-parts", "Every part by every method: mean over its volume (5 % to 95 % of it)")
    table.add("part", "method", is_number=False)
    table.add("volume", why="deformed")
    table.add("volume change")
    spreads = [key for key in SPREADS if any(at(row, "mechanics", "body", key) for row in rows)]
    for key in spreads:
        table.add(SPREADS[key][0], why="mean over the volume, and what 5 % and 95 % of it do not exceed")
    table.add("energy", why="elastic strain energy")
    wanted = next((row for row in rows if row["method"] == reference), None)
    # Along fibres where there are some.
    compared = [next((key for key in pair if key in spreads), "") for pair in (("fibre_strain", "largest_strain"), ("fibre_stress", "von_mises"))]
    compared = [key for key in compared if key] if wanted else []
    for label in [SPREADS[key][0] for key in compared] + ["energy"] * bool(compared):
        table.add(label + " error", why=f"relative to the same part's by {reference}")
    volume = partial(measured, unit={3: "m^3", 2: "m^2"}.get(dimension, "m"))
    energy = said(".4g", " J/m" if dimension == 2 else " J")
    for i in range(max((len(_parts_of(row)) for row in rows), default=0)):
        for row in rows:
            part, truth = at(_parts_of(row), i), at(_parts_of(wanted), i) if wanted and row is not wanted else None
            if part is None:
                continue
            change = at(part, "volume_change")
            cells = [text_cell(_name_of_part(part)), text_cell(row["method"]), figure_cell(volume, part, "volume"),
                     cell(percent(clean(change, _largest_figure(part, True))), change)]  # fmt: skip
            cells += [_spread_cell(part, key) for key in spreads]
            cells.append(figure_cell(energy, part, "strain_energy"))
            for path in [(key, "mean") for key in compared] + [("strain_energy",)] * bool(compared):
                cells.append(_error_cell(at(part, *path), at(truth, *path)))
            table.append(cells, row["method"] == reference)
    return table


def _forces_table(rows: List[Data], reference: str, dimension: int, name: str) -> Table:
    table = Table(name + "-forces", "Forces on the body, and moments about the middle of where they act, in the world's axes")
    table.add("on", "where", "method", is_number=False)
    for what, unit in (("force", "N/m" if dimension == 2 else "N"), ("moment", "N" if dimension == 2 else "N m")):
        table.add(*(f"{what} {axis} [{unit}]" for axis in "xyz"))
    for kind in ("holds", "moves", "loads"):
        for i in range(max((len(listed(row, "mechanics", kind)) for row in rows), default=0)):
            for row in rows:
                one = at(row, "mechanics", kind, i)
                if one is None:
                    continue
                force, moment = at(one, "force"), at(one, "moment")
                # Lever arms are as long as the place is far from the origin: rounding beside that is 0.
                largest = max(length(moment), length(force) * length(at(one, "centroid")))
                cells = [text_cell(words(one, "name")), text_cell(words(one, "where")), text_cell(row["method"])]
                for vector, most in ((force, length(force)), (moment, largest)):
                    cells += [cell(said(".4g")(clean(at(vector, a), most)), at(vector, a)) for a in range(3)]
                table.append(cells, row["method"] == reference)
    return table


def _costs_table(rows: List[Data], reference: str, name: str) -> Table:
    table = Table(name + "-table", "All methods; a click on a header sorts")
    table.add("method", "status", is_number=False)
    table.add("set-up", "solve", "total", "iterations", "memory")
    table.add("violation", why="by how much a link is outside its limits, in spacings")
    errors = [key for i, key in enumerate(ERRORS) if any(number(row, "error", key) is not None or (i < 2 and at(row, "error")) for row in rows)]
    for key in errors:
        table.add(ERRORS[key], why=f"relative, against {reference}")
    has_estimate = any(at(row, "estimated_error") for row in rows)
    if has_estimate:
        table.add("estimated L2", why="relative L2 error against elasticity, without finite elements")
    for row in rows:
        violation = at(row, "limit_violation")
        cells = [text_cell(row["method"]), text_cell(plain(at(row, "status")))]
        cells += [figure_cell(seconds, row, "seconds", part) for part in ("setup", "solve", "total")]
        cells += [figure_cell(plain, row, "iterations"), figure_cell(in_bytes, row, "bytes"), cell(said(".2g")(clean(violation, 1)), violation)]
        cells += [figure_cell(percent, row, "error", key) for key in errors]
        cells += [figure_cell(percent, row, "estimated_error", "relative_l2")] * has_estimate
        table.append(cells, row["method"] == reference)
    return table


def _method_of(row: Data, maps: List[Data]) -> Data:
    figures = {"set-up": seconds(at(row, "seconds", "setup")), "solve": seconds(at(row, "seconds", "solve")), "memory": in_bytes(at(row, "bytes")),
               "iterations": plain(at(row, "iterations")), "solver error": percent(at(row, "residual")),
               "strain energy": said(".6g", " J")(at(row, "strain_energy")), "L2 error": percent(at(row, "error", "relative_l2")),
               "largest error": percent(at(row, "error", "relative_max")),
               "estimated L2 error": percent(at(row, "estimated_error", "relative_l2")),
               "no estimate": words(row, "estimated_error_message") or NONE,
               "the estimate took": seconds(at(row, "estimated_error", "seconds"))}  # fmt: skip
    return {"method": row["method"], "status": plain(at(row, "status")), "algorithm": words(row, "algorithm"), "message": words(row, "message"),
            "figures": {name: value for name, value in figures.items() if value != NONE}, "maps": maps}  # fmt: skip


def _plots(rows: List[Data], reference: str) -> List[Data]:
    """Error over time and over memory; estimated errors where there are no true ones."""
    is_true = any(at(row, "error") for row in rows)
    key, against = ("error", " against " + reference) if is_true else ("estimated_error", "")
    plots: List[Data] = []
    for what, unit, path, factor in (("time", "time, set-up and solve [ms]", ("seconds", "total"), 1e3), ("memory", "memory [MiB]", ("bytes",), 2.0**-20)):
        series: Series = {}
        for row in rows:
            error, value = number(row, key, "relative_l2") or 0, number(row, *path) or 0
            if error > 0 and value > 0:
                series[row["method"]] = [(factor * value, 100 * error)]
        if len(series) > 1:
            plots.append(plot(series, (unit, ("" if is_true else "estimated ") + "relative L2 error [%]"),
                              f"Plot of the error of every method{against} over its {what}; the table has the figures",
                              f"What accuracy costs in {what}" + (f", errors{against}" if against else ""), log="xy"))  # fmt: skip
    return plots


def _notes(comparison: Any, rows: List[Data]) -> List[str]:
    notes = []
    error = at(comparison, "reference_error")
    if isinstance(error, dict):
        notes.append(f"The reference is itself some {percent(at(error, 'relative_l2'))} (L2) off at most: its difference from "
                     f"{plain(at(error, 'against'))}.")  # fmt: skip
    notes += [plain(warning) + "." for warning in listed(comparison, "warnings")]
    if any(at(row, "estimated_error") for row in rows):
        notes.append("Estimated errors are those against linear elasticity of the same cells, found without finite elements by a few multigrid cycles.")
    notes += [f"Forces by {row['method']}: {plain(caveat)}." for row in rows for caveat in listed(row, "mechanics", "caveats")]
    return distinct(notes) + ["Left out: " + plain(at(piece, "name")) for piece in listed(comparison, "left_out")]


def answers_section(results: Data, drawn: Optional[Data]) -> Data:
    """@param results  SCENE_compare_results.json or SCENE_run_results.json; drawn: pictures of its bodies, and the question in words"""
    rows, comparison = _rows_of(results), at(results, "results", 0)
    kind, scene, reference = words(results, "kind"), plain(at(results, "scene")), words(comparison, "reference")
    dimension, threads, name = number(comparison, "dimension"), at(comparison, "threads"), name_as_id(f"{scene}-{kind}")
    with_mechanics = [row for row in rows if isinstance(at(row, "mechanics"), dict)]
    size = int(dimension) if dimension in (1, 2, 3) else 3
    tables = [_measures_table(rows, reference, name), _parts_table(with_mechanics, reference, size, name),
              _forces_table(with_mechanics, reference, size, name)]  # fmt: skip
    maps = at(drawn, "maps") or {}
    return {
        "id": name,
        "heading": f"{'Run' if kind == 'run' else 'Comparison'}: {words(results, 'title') or scene}",
        "summary": f"{plain(dimension)}D, {plain(at(comparison, 'cells'))} cells, {plain(at(comparison, 'nodes'))} nodes, {plain(threads)} thread"
        f"{'' if threads == 1 else 's'}{f', errors against {reference}' if reference else ''}.",
        "notes": _notes(comparison, rows),
        "question": words(drawn, "question"),
        "body": listed(drawn, "body"),
        "tables": [table for table in tables if table.rows],
        "conventions": next((words(row, "mechanics", "conventions") for row in rows if words(row, "mechanics", "conventions")), ""),
        "pictures": listed(drawn, "pictures"),
        "table": _costs_table(rows, reference, name),
        "plots": _plots(rows, reference),
        "methods": [_method_of(row, listed(maps, row["method"])) for row in rows],
        **asked(results),
    }
