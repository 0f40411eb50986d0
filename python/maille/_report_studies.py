"""Sections of what was asked over many scenes, moved by hand or touched: studies, trades, plays, probes.

Each takes what the command wrote as JSON, and pictures that lie beside it, and returns what the page's template
shows of a section. Every row of a study is on the page, up to MOST_ROWS.
"""

from __future__ import annotations

import statistics
from typing import Any, Dict, List, Optional

from ._report_parts import (NOISE, NONE, Data, Series, Table, asked, at, cell, clean, distinct, figure_cell, in_bytes, largest_of, length, listed, measured, name_as_id, number,
                            percent, plain, plot, said, seconds, text_cell, words)  # fmt: skip
from ._report_answers import measure_cells, measure_columns

MOST_ROWS = 20000  #: that a page shows
MOST_POINTS = 4000  #: more in one plot cannot be told apart, and make the page heavy
MOST_SERIES = 8
MOST_LINED = 40  #: values of a parameter that a line joins


def _names_below(key: str, rows: List[Data]) -> List[str]:
    return distinct(name for row in rows if isinstance(at(row, key), dict) for name in row[key])


def _study_table(rows: List[Data], parameters: List[str], scenes: List[str], name: str) -> Table:
    shown = rows[:MOST_ROWS]
    table = Table(name + "-table", f"All {len(rows)} rows; a click on a header sorts" if len(shown) == len(rows) else
                  f"The first {len(shown)} of {len(rows)} rows; a click on a header sorts")  # fmt: skip
    table.add("case")
    if len(scenes) > 1:
        table.add("scene", is_number=False)
    for parameter in parameters:
        table.add(parameter, is_number=any(number(row, "parameters", parameter) is not None for row in rows))
    table.add("method", "status", is_number=False)
    table.add("L2 error", "max error", "total", "memory", "iterations")
    own = [key for key in ("force", "strain_energy") if any(number(row, key) is not None for row in rows)]
    measures = [key for key in _names_below("measures", rows) if key not in own]
    table.add(*(key.replace("_", " ") if key in own else key for key in own + measures))
    has_messages = any(words(row, "message") for row in shown)
    table.add(*["message"] * has_messages, is_number=False)
    largest = {key: largest_of(value for row in rows for value in (at(row, "measures", key), at(row, key))) for key in own + measures}
    for row in shown:
        cells = [figure_cell(plain, row, "case")] + [text_cell(plain(at(row, "scene")))] * (len(scenes) > 1)
        values = [at(row, "parameters", parameter) for parameter in parameters]
        cells += [text_cell(plain(value)) if number(value) is None else cell(plain(value), value) for value in values]
        cells += [text_cell(plain(at(row, key))) for key in ("method", "status")]
        cells += [figure_cell(percent, row, "error", norm) for norm in ("relative_l2", "relative_max")]
        cells += [figure_cell(seconds, row, "seconds", "total"), figure_cell(in_bytes, row, "bytes"), figure_cell(plain, row, "iterations")]
        for key in own + measures:
            is_measure = at(row, "measures", key) is not None
            value = clean(at(row, "measures", key) if is_measure else at(row, key), largest[key])
            unit = words(row, "measure_units", key) if is_measure else {"force": "N", "strain_energy": "J"}.get(key, "")
            cells.append(cell(measured(value, unit), value))
        table.append(cells + [text_cell(words(row, "message"))] * has_messages)
    return table


def _errors_over(rows: List[Data], parameter: str) -> Series:
    """By method, the median error at every value of a parameter over all cases that share it."""
    errors: Dict[str, Dict[float, List[float]]] = {}
    for row in rows:
        value, error = number(row, "parameters", parameter), number(row, "error", "relative_l2")
        if value is not None and error is not None and error > 0:
            errors.setdefault(plain(at(row, "method")), {}).setdefault(value, []).append(error)
    return {method: [(value, 100 * statistics.median(of[value])) for value in sorted(of)] for method, of in errors.items()}


def _study_plots(rows: List[Data], parameters: List[str], scenes: List[str]) -> List[Data]:
    plots = []
    for scene in scenes:
        where = f"{scene}: " if len(scenes) > 1 else ""
        for parameter in parameters:
            series = _errors_over([row for row in rows if plain(at(row, "scene")) == scene], parameter)
            values = [x for points in series.values() for x, _ in points]
            is_anyhow = len(set(values)) > MOST_LINED  # drawn at random, with the other parameters
            series = {method: points[:: len(values) // MOST_POINTS + 1] for method, points in series.items()}
            if len(set(values)) > 1:
                plots.append(plot(series, (parameter, "relative L2 error [%]" + ("" if is_anyhow else ", median")),
                                  f"Plot of the median error of every method over {where}{parameter}; the table has the figures",
                                  f"{where}error over {parameter}" + ("" if is_anyhow else "; at every value the median over all cases that share it"),
                                  log="xy" if min(values) > 0 and max(values) >= 30 * min(values) else "y", lines=not is_anyhow))  # fmt: skip
    over_time: Series = {}
    for row in rows[:: len(rows) // MOST_POINTS + 1]:
        error, time = number(row, "error", "relative_l2") or 0, number(row, "seconds", "total") or 0
        if error > 0 and time > 0:
            over_time.setdefault(plain(at(row, "method")), []).append((1e3 * time, 100 * error))
    if over_time:
        plots.append(plot(over_time, ("time, set-up and solve [ms]", "relative L2 error [%]"),
                          "Plot of the error of every case and method over its time; the table has the figures",
                          "What accuracy costs in time, one point a case and method", log="xy"))  # fmt: skip
    return plots


def _sensitivity(about: Any, name: str, notes: List[str]) -> Table:
    """Which parameter makes which share, as `study` has found."""

    def share(parameter: Any, key: str) -> Data:
        value, low, high = (number(parameter, key + end) for end in ("", "_low", "_high"))
        if value is None or low is None or high is None:
            return cell(NONE)
        return cell(f"{value:.3f}" + ("" if low == high else f" ({low:.2f} to {high:.2f})"), value)

    table = Table(name + "-sensitivity", "Sobol indices: shares of the variance, with intervals of 95 %")
    table.add("of", "scene", "method", "parameter", is_number=False)
    table.add("alone", why="first-order index")
    table.add("with others", why="total index")
    for one in listed(about, "sensitivity"):
        whose = [plain(at(one, key)) for key in ("label", "scene", "method")]
        if words(one, "undetermined"):
            notes.append(f"Sensitivity of {', '.join(whose)}: undetermined: {words(one, 'undetermined')}.")
            continue
        for parameter in listed(one, "parameters"):
            table.append([*map(text_cell, whose), text_cell(plain(at(parameter, "parameter"))), share(parameter, "first"), share(parameter, "total")])
    return table


def _response_picture(rows: List[Data], title: str) -> List[Data]:
    """What the study is about over its parameters, as `study --picture` draws it; tables of older versions may lack what that needs."""
    from ._plots import figure_as_data_uri
    from ._study import default_response, study_figure

    try:
        response = default_response(rows)
        figure = study_figure(rows, title, response)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError):
        return []
    return [{"source": figure_as_data_uri(figure), "look": "picture", "alt": f"{response} over what was varied; the table has the figures",
             "caption": f"{response} over what was varied"}]  # fmt: skip


def study_section(rows: List[Data], stem: str, about: Any) -> Data:
    """@param rows  of the table of JSON lines, at least one; stem: the table's name; about: NAME_about.json, or None"""
    parameters, scenes = _names_below("parameters", rows), distinct(plain(at(row, "scene")) for row in rows)
    cases = {row["case"] for row in rows if isinstance(at(row, "case"), int)}
    unsettled = sum(at(row, "status") not in ("done", "clamped") for row in rows)
    varied = [name for name in parameters if any(at(row, "parameters", name) != at(rows[0], "parameters", name) for row in rows)]
    title = words(about, "title") or words(rows[0], "study") or stem
    what = "does the force depend" if any(number(row, "force") is not None for row in rows) else "do the answers depend"
    notes: List[str] = []
    table = _sensitivity(about, name_as_id(stem), notes)
    return {
        "id": name_as_id(stem),
        "heading": "Study: " + title,
        "summary": f"{len(cases)} of {plain(at(rows[0], 'cases'))} cases, {len(rows)} rows, {unsettled} of them not settled; "
        f"scene{'s' if len(scenes) > 1 else ''} {', '.join(scenes)}, errors against {plain(at(rows[0], 'reference'))}.",
        "notes": notes,
        "question": f"How {what} on {' and '.join(varied)}?" if varied else "What do the methods answer?",
        "body": _response_picture(rows, title),
        "tables": [table] if table.rows else [],
        "tables_heading": "What matters most",
        "plots": _study_plots(rows, parameters, scenes),
        "table": _study_table(rows, parameters, scenes, name_as_id(stem)),
        **asked(about),
    }


def trade_section(trade: Data, pictures: List[Data]) -> Data:
    """@param trade  what `trade --json` says"""
    rows = [row for row in listed(trade, "rows") if isinstance(row, dict)]
    scene, threads, error = plain(at(trade, "scene")), at(trade, "threads"), number(trade, "reference_error", "relative_l2")
    table = Table(name_as_id(scene + "-trade-table"), "Every method on every lattice and to every tolerance; a click on a header sorts")
    table.add("method", is_number=False)
    table.add("spacing", why="of the lattice over the scene's")
    table.add("nodes", "tolerance")
    table.add("status", is_number=False)
    table.add("total", "memory", "iterations", "L2 error", "max error")
    table.add("front", is_number=False, why="nothing is both nearer and quicker (time), or both nearer and smaller (memory)")
    measures = measure_columns(rows)
    for name in measures:
        table.add(name, name + " error")
    for row in rows[:MOST_ROWS]:
        cells = [text_cell(plain(at(row, "method")))] + [figure_cell(plain, row, key) for key in ("spacing_factor", "nodes", "tolerance")]
        cells += [text_cell(plain(at(row, "status"))), figure_cell(seconds, row, "seconds", "total"), figure_cell(in_bytes, row, "bytes"),
                  figure_cell(plain, row, "iterations")]  # fmt: skip
        cells += [figure_cell(percent, row, "error", norm) for norm in ("relative_l2", "relative_max")]
        cells.append(text_cell(", ".join(which for which in ("time", "memory") if at(row, "on_front", which) is True)))
        for name in measures:
            cells += measure_cells(rows, row, name)
        table.append(cells)
    return {
        "id": name_as_id(scene + "-trade"),
        "heading": "Trade: " + (words(trade, "title") or scene),
        "summary": f"{plain(at(trade, 'dimension'))}D, {plain(at(trade, 'cells'))} cells, {plain(at(trade, 'nodes'))} nodes, {plain(threads)} thread"
        f"{'' if threads == 1 else 's'}, errors against {plain(at(trade, 'reference'))} ({plain(at(trade, 'reference_algorithm'))}).",
        "notes": [] if error is None else [f"The reference is itself some {percent(error)} (L2) off at most."],
        "body": pictures,
        "table": table,
        **asked(trade),
    }


def play_section(results: Any, frames: Any, moments: List[Data]) -> Data:
    """@param results  what `play --out` wrote, or None; frames: what `play --json` says, or None; moments: pictures of some frames"""
    scene, named = plain(at(results or frames, "scene")), results or frames
    step = number(frames, "frame_seconds") or 1.0
    forces: Dict[str, List[Any]] = {}  # (time, size) of what acts, under its name
    for frame in listed(frames, "frames"):
        acting = [("drive of " + plain(at(drive, "object")), drive) for drive in listed(frame, "drives")]
        acting += [(f"{plain(at(one, 'object'))} against {plain(at(one, 'other'))}", one) for one in listed(frame, "contacts")]
        for name, one in acting:
            forces.setdefault(name, []).append((number(frame, "frame"), length(at(one, "force"))))
    largest = {name: max(size for _, size in one) for name, one in forces.items()}
    noise = NOISE * max(largest.values(), default=0)
    table = Table(name_as_id(scene + "-play") + "-table", "What objects and drives did to each other")
    table.add("what", is_number=False)
    table.add("frames", "largest force")
    for name in sorted(forces):
        table.append([text_cell(name), cell(str(len(forces[name])), len(forces[name])),
                      cell(f"{largest[name]:.4g} N" if largest[name] > noise else NONE, largest[name])])  # fmt: skip
    series = {name: [(step * at_frame, size) for at_frame, size in one if at_frame is not None and size > noise] for name, one in forces.items()}
    series = {name: one for name, one in series.items() if one}
    plots = []
    if 0 < len(series) <= MOST_SERIES:
        alt = "Plot of the forces over time; the table has the largest"
        plots = [plot(series, ("time [s]", "force [N]"), alt, "Forces over time", lines=True)]
    summary = f"{scene}, by {words(named, 'method') or 'its methods'}"
    summary += f", driven by {words(frames, 'trajectory')}" if words(frames, "trajectory") else ""
    if isinstance(at(frames, "frames"), list):
        summary += f"; {len(frames['frames'])} of {plain(at(frames, 'frames_asked'))} frames"
    elif number(results, "moments") is not None:
        summary += f"; {plain(at(results, 'moments'))} moments"
    return {
        "id": name_as_id(scene + "-play"),
        "heading": "Play: " + (words(results, "title") or scene),
        "question": "How do the objects of this world move when they are driven, where do they touch, and with what force?",
        "summary": summary + ".",
        "body": moments,
        "table": table if table.rows else None,
        "plots": plots,
        **asked(results),
    }


def probe_section(probe: Data, stem: str, pictures: List[Data]) -> Data:
    """@param probe  what `play --json` of a hand says; stem: the file's name without ending"""
    period: Optional[float] = number(probe, "period_s")
    rate = f" at {1 / period:.4g} a second" if period is not None and period > 1e-12 else ""
    inside = number(probe, "penetrations") or 0
    rows = {"largest force": said(".4g", " N")(at(probe, "force", "largest_n")),
            "mean force while touching": said(".4g", " N")(at(probe, "force", "mean_touching_n")),
            "largest torque": said(".4g", " N m")(at(probe, "force", "largest_torque_nm")),
            "ticks in touch": plain(at(probe, "force", "touching_ticks")),
            "deepest indentation": said(".4g", " mm", 1e3)(at(probe, "bodies", "deepest_m")),
            "slowest answer of a body": seconds(at(probe, "bodies", "slowest_answer_s")),
            "stiffness of the coupling": said(".4g", " N/m")(at(probe, "passivity", "stiffness")),
            "least energy of the device": said(".4g", " J")(at(probe, "passivity", "least_energy_j")),
            "missed deadlines": plain(at(probe, "missed_deadlines"))}  # fmt: skip
    table = Table(name_as_id(stem + "-probe-table"), "What was felt, and what it cost")
    table.add("figure", "value", is_number=False)
    for name, value in rows.items():
        if value not in (NONE, ""):
            table.append([text_cell(name), text_cell(value)])
    return {
        "id": name_as_id(stem + "-probe"),
        "heading": "Probe: " + (words(probe, "title") or stem),
        "question": "What does a hand feel that touches this body with a tool, and does the loop keep its time?",
        "summary": f"{plain(at(probe, 'ticks'))} ticks{rate}, {'in real time' if at(probe, 'in_real_time') is True else 'without a clock'}; "
        f"a tool of {plain(at(probe, 'tool_voxels'))} voxels, {plain(at(probe, 'deformable_bodies'))} deformable bodies.",
        "notes": [f"The tool was in matter in {plain(inside)} of {plain(at(probe, 'looks'))} looks: forces there are not to be believed."] * (inside > 0),
        "body": pictures,
        "table": table,
        **asked(probe),
    }
