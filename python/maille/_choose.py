"""The cheapest way to answer a scene within an error and a time, before it is answered.

Two parts make a prediction. *Probes* (the command's) answer the scene on coarser lattices; their differences and
times, scaled by simple rules, are the *raw* predictions. A *table* of trades measured on other scenes says how far
measured values lie from raw ones, as ratios: their median corrects, their quantiles are the uncertainty (split
conformal prediction: Papadopoulos and others 2002; Lei and others 2018, section 2.2, on the logarithm). The promise
is the upper quantile: it holds as often as it says for scenes drawn as those of the table were, and for others as
often as ``studies/lab/run choices`` measures.

A scene unlike those of the table in kind is not promised by it: three lattices of its own speak for its error, and
twice what they tell is promised. So it is with errors of force, energy and stress, of which the table holds none.

A *way* is a method, how often it halves the scene's spacing, and a tolerance where the method has one.
"""

from __future__ import annotations

import csv
import io
import json
import math
import os
import shlex
import tempfile
from pathlib import Path
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Sequence, Set, Tuple, Union

from ._command import run, scene_files
from ._faults import Fault, SceneFaults, count, number_above_0
from ._program import deliver, in_json, print_safely, write_whole
from ._progress import Progress, told
from ._scene import Scene
from ._words import in_bytes, in_percent, in_seconds

MARGIN_WITHOUT_TABLE = 2  # the promise of three lattices: the expected error times and divided by this
MOST_HALVINGS = 10  # that ``maille study trade --spacings`` takes
BUILT_IN_TABLE = Path(__file__).with_name("trade_table.csv")


class Way(NamedTuple):
    method: str
    halvings: int
    tolerance: Optional[float]

    @property
    def has_own_tolerance(self) -> bool:
        return self.tolerance is not None and not self.method.startswith("fem_")


class StoredRow(NamedTuple):
    """One measured row of a trade and its raw prediction."""

    way: Way  # as if the probes had been on lattices of twice and four times the spacing: finer ones shift it
    error: float
    predicted_error: float
    seconds: float
    predicted_seconds: float
    scene: str = ""  # name and nodes: a scene, a way and a prediction count once


class Expected(NamedTuple):
    median: float
    low: float
    high: float


def _rank(n: int, level: float) -> int:
    """Rounding must not reach for the next value."""
    return max(1, math.ceil((n + 1) * level - 1e-9))


def upper_quantile(ordered: Sequence[float], level: float) -> float:
    """The value that a fraction ``level`` of draws does not exceed: the ceil((n + 1) level)-th smallest of n, infinite where n is too small."""
    rank = _rank(len(ordered), level)
    return ordered[rank - 1] if rank <= len(ordered) else math.inf


def lower_quantile(ordered: Sequence[float], level: float) -> float:
    """The value that a fraction ``level`` of draws is not below; 0 where n is too small."""
    rank = _rank(len(ordered), level)
    return ordered[-rank] if rank <= len(ordered) else 0.0


def fewest_scenes(level: float) -> int:
    """The fewest scenes of which a quantile says anything: 19 at a level of 95 %."""
    return next(n for n in range(1, 10**9) if _rank(n, level) <= n)


class Calibration:
    """Ratios of measured to raw values, by way. A row that stands there twice counts once."""

    def __init__(self, rows: Sequence[StoredRow]) -> None:
        self.ratios: Dict[Way, Tuple[List[float], List[float]]] = {}
        seen: Set[Tuple[Way, str, str]] = set()
        for row in rows:
            key = (row.way, row.scene, f"{row.predicted_error:.4g}")
            if row.scene and key in seen:
                continue
            seen.add(key)
            error, seconds = self.ratios.setdefault(row.way, ([], []))
            error.append(row.error / row.predicted_error)
            seconds.append(row.seconds / row.predicted_seconds)
        for of_way in self.ratios.values():
            for ratios in of_way:
                ratios.sort()

    @property
    def scenes(self) -> int:
        """Different scenes that the best known way was measured on."""
        return max((len(error) for error, _ in self.ratios.values()), default=0)

    def expected(self, way: Way, what: str, raw: float, level: float) -> Expected:
        """@param what  "error" or "seconds" @param level  how often the high end is to hold, and the low end"""
        ratios = self.ratios[way][what == "seconds"]
        return Expected(raw * ratios[(len(ratios) - 1) // 2], raw * lower_quantile(ratios, level), raw * upper_quantile(ratios, level))


def parse_trade_table(text: str, name: str) -> List[StoredRow]:
    """Rows of a table that ``maille study trade`` wrote. Rows without measurement or prediction are passed over, and those
    whose reference does not know its own error; an error below that counts as that.

    Raises:
        SceneFaults: every fault with its line: a missing column, a cell that is no number
    """
    reader = csv.reader(io.StringIO(text, newline=""))
    names: List[str] = next(reader, [])
    numbers = ("nodes", "halvings", "tolerance", "total_s", "relative_l2", "predicted_error", "predicted_s", "reference_l2")
    faults = [Fault(name, 1, column, "a column of that name", "none") for column in ("method", "status", "scene", *numbers) if column not in names]
    faults += [Fault(name, 1, column, "each column once", f'"{column}" again') for column in set(names) if names.count(column) > 1]
    rows = []
    try:
        for cells in reader if not faults else ():
            if len(cells) != len(names):
                faults.append(Fault(name, reader.line_num, "", f"{len(names)} cells", str(len(cells))))
                continue
            row, known = dict(zip(names, cells)), len(faults)
            value: Dict[str, Optional[float]] = {}
            for column in numbers + ("probe_halvings",):
                cell = row.get(column, "")
                try:
                    value[column] = float(cell) if cell else None
                except ValueError:
                    faults.append(Fault(name, reader.line_num, column, "a number", f'"{cell}"'))
            halvings = value.get("halvings")
            if len(faults) == known and (halvings is None or halvings not in range(-MOST_HALVINGS, MOST_HALVINGS + 1)):
                faults.append(Fault(name, reader.line_num, "halvings", f"a whole number from -{MOST_HALVINGS} to {MOST_HALVINGS}", f'"{row["halvings"]}"'))
            if len(faults) == known:
                rows += _stored(row, value)
    except csv.Error as error:
        faults.append(Fault(name, reader.line_num, "", "a table", str(error)))
    if faults:
        raise SceneFaults("\n".join(map(str, faults)), faults)
    return rows


def _stored(row: Dict[str, str], value: Dict[str, Optional[float]]) -> List[StoredRow]:
    figures = [value[column] or 0.0 for column in ("relative_l2", "predicted_error", "total_s", "predicted_s")]
    reference = value["reference_l2"]
    if row["status"] not in ("done", "clamped") or reference is None or value["relative_l2"] is None:
        return []
    figures[0] = max(figures[0], reference)  # what the reference cannot tell apart from itself may be as far off as it is
    if not all(figure > 0 and math.isfinite(figure) for figure in figures):
        return []
    probes, halvings, nodes = value["probe_halvings"], int(value["halvings"] or 0), value["nodes"] or 0
    if probes is not None and probes in range(MOST_HALVINGS + 1):
        halvings -= int(probes) + 1
    error, predicted_error, seconds, predicted_seconds = figures
    return [StoredRow(Way(row["method"], halvings, value["tolerance"]), error, predicted_error, seconds, predicted_seconds, f"{row['scene']} {nodes:g}")]


def read_trade_tables(files: Sequence["str | os.PathLike[str]"]) -> List[StoredRow]:
    """Reads tables of ``study trade``.

    Raises:
        SceneFaults: every fault; also for a file that cannot be read
    """
    rows = []
    for file in files or [BUILT_IN_TABLE]:
        try:
            with open(file, encoding="utf-8", errors="replace", newline="") as stream:
                text = stream.read()
        except OSError as error:
            fault = Fault(os.fspath(file), 0, "", "a table", str(error.strerror))
            raise SceneFaults(str(fault), [fault]) from None
        rows += parse_trade_table(text, os.fspath(file))
    return rows


# The choice


def _known_way(way: Way, shift: int, calibration: Calibration) -> Way:
    """The way of the table that is as much finer than its probes as ``way`` is than these; the nearest that it has."""
    known = way._replace(halvings=way.halvings - shift)
    while known.halvings < way.halvings and known not in calibration.ratios:
        known = known._replace(halvings=known.halvings + 1)
    return known


def _candidate(way: Way, prospect: Dict[str, Any], request: Dict[str, Any], calibration: Calibration) -> "Union[str, Dict[str, Any]]":
    """What a way is expected to come to, or why nothing is said."""
    if "why_not" in prospect:
        return str(prospect["why_not"])
    shift, level, growth = request["probe_halvings"] + 1, request["wish"]["level"], request["probes"].get("growth")
    known, is_fem = _known_way(way, shift, calibration), way.method.startswith("fem_")
    raw = prospect["error"] if is_fem else math.hypot(prospect["error"], way.tolerance or 0)
    if growth is not None:
        error = Expected(raw, raw / MARGIN_WITHOUT_TABLE, raw * MARGIN_WITHOUT_TABLE)
    elif known.halvings == way.halvings - shift:
        error = calibration.expected(known, "error", raw, level)
    else:
        return "the table does not know it for probes so fine"
    seconds = calibration.expected(way if is_fem else known, "seconds", prospect["seconds"], level)
    return {"method": way.method, "spacing_factor": 2.0**-way.halvings, "tolerance": way.tolerance,
            "cells": prospect["cells"], "spacing": prospect["spacing"], "nodes": prospect["nodes"],
            "error": dict(zip(("expected", "low", "high"), error)), "seconds": dict(zip(("expected", "low", "high"), seconds)),
            "bytes": prospect["bytes"], "way": way}  # fmt: skip


def meets(candidate: Dict[str, Any], wish: Dict[str, Any]) -> bool:
    """Whether both upper ends are within the wish, and the memory is."""
    fits = wish.get("bytes") is None or candidate["bytes"] <= wish["bytes"]
    return bool(candidate["error"]["high"] <= wish["error"] and candidate["seconds"]["high"] <= wish["seconds"] and fits)


def _end_of(key: str, end: str = "high") -> Callable[[Any], float]:
    return lambda candidate: float(candidate[key][end])


def pick(candidates: Sequence[Dict[str, Any]], wish: Dict[str, Any]) -> Dict[str, Optional[Dict[str, Any]]]:
    """The cheapest that meets the wish; where none does, the nearest ones that fit into the memory.

    @param candidates  by expected time
    """
    chosen = next((one for one in candidates if meets(one, wish)), None)
    fits = [one for one in candidates if chosen is None and (wish.get("bytes") is None or one["bytes"] <= wish["bytes"])]
    in_time = [one for one in fits if one["seconds"]["high"] <= wish["seconds"]]
    to_error = [one for one in fits if one["error"]["high"] <= wish["error"]]
    return {"chosen": chosen, "most_exact_in_time": min(in_time, key=_end_of("error"), default=None),
            "quickest_to_error": min(to_error, key=_end_of("seconds"), default=None)}  # fmt: skip


def choice_of(request: Dict[str, Any], rows: Sequence[StoredRow]) -> Dict[str, Any]:
    """The choice as ``study choose --json`` writes it; candidates have their "way" too.

    @param request  of the command: "wish", "probes", and "prospects", what is known of a method on a lattice
    """
    calibration = Calibration(rows)
    prospects = {(one["method"], one["halvings"]): one for one in request["prospects"]}
    candidates, left_out = [], []
    for way in calibration.ratios if not request["why_not"] else ():
        found = _candidate(way, prospects.get((way.method, way.halvings), {"why_not": "it is not probed"}), request, calibration)
        if isinstance(found, str):
            left_out.append(f"{way.method} at {2.0**-way.halvings:g} times the spacing: {found}")
        else:
            candidates.append(found)
    candidates.sort(key=_end_of("seconds", "expected"))
    growth = request["probes"].get("growth")
    return {"scene": request["scene"], "maille": request["maille"], "wish": request["wish"], "scenes_in_table": calibration.scenes,
            "rests_on": "table" if growth is None else "three lattices", "probes": request["probes"],
            **({"message": request["why_not"]} if request["why_not"] else {}), **pick(candidates, request["wish"]),
            "candidates": candidates, "left_out": list(dict.fromkeys(left_out))}  # fmt: skip


# Words


def _in_words(one: Dict[str, Any]) -> str:
    tolerance = f", tolerance {one['tolerance']:g}" if one["tolerance"] is not None else ""
    cells, spacing = " x ".join(map(str, one["cells"])), " x ".join(f"{1e3 * length:.4g}" for length in one["spacing"])

    def ends(of: str, words: Any) -> str:
        return f"{words(one[of]['expected'])} ({words(one[of]['low'])} to {words(one[of]['high'])})"

    return (f"{one['method']} at {one['spacing_factor']:g} times the scene's spacing{tolerance}\n    {cells} cells of {spacing} mm, {one['nodes']} nodes\n"
            f"    error  {ends('error', in_percent)}\n    time   {ends('seconds', in_seconds)}\n    memory {in_bytes(one['bytes'])} at most\n")  # fmt: skip


def _why_to_believe(choice: Dict[str, Any]) -> str:
    probes, of = choice["probes"], choice["wish"]["of"]
    if probes.get("growth") is None:
        return f"    the upper ends are kept in {in_percent(choice['wish']['level'])} of scenes like those of the table\n"
    grow = f"whose differences grow by {probes['growth']:.2g} with the spacing; the upper end is twice what they tell\n"
    if of != "displacement":
        return f"    the table holds no errors of {of}: three lattices speak for it, {grow}"
    return f"    the scene is unlike those of the table ({', '.join(probes['unlike_the_table'])}): three lattices speak for its error, {grow}"


def choice_in_words(choice: Dict[str, Any], title: str) -> str:
    wish, probes = choice["wish"], choice["probes"]
    of = "" if wish["of"] == "displacement" else f" of {wish['of']}"
    text = f"{title}\nwanted: an error of {in_percent(wish['error'])}{of} in {in_seconds(wish['seconds'])}"
    text += f" and {in_bytes(wish['bytes'])}\n" if wish.get("bytes") is not None else "\n"
    if choice.get("message"):
        return f"{text}nothing can be promised: {choice['message']}\n"
    factor = probes["spacing_factor"]
    text += f"probes: {in_seconds(probes['seconds'])}; lattices of {factor:g} and {2 * factor:g} times the spacing differ by {in_percent(probes['difference'])}{of}\n"
    if choice["chosen"]:
        text += "\nchosen: " + _in_words(choice["chosen"]) + _why_to_believe(choice)
    else:
        text += "\nnone is expected to meet that\n"
        nearest = [(f"the {words}: ", choice[key]) for words, key in (("most exact in that time", "most_exact_in_time"), ("quickest to that error", "quickest_to_error"))]
        text += "".join(words + _in_words(one) for words, one in nearest if one) or "nothing is in that time alone, nor to that error alone\n"
        scenes, least = choice["scenes_in_table"], fewest_scenes(wish["level"])
        if scenes < least and probes.get("growth") is None:
            text += (f"the table holds {scenes} different scene{'' if scenes == 1 else 's'}: a promise that is kept in {in_percent(wish['level'])} of scenes "
                     f"needs at least {least} (`maille study trade`), or a lower --level\n")  # fmt: skip
    return text + ("\nnot considered:\n" if choice["left_out"] else "") + "".join(f"    {line}\n" for line in choice["left_out"])


def _how_to_do_it(request: Dict[str, Any], chosen: Dict[str, Any]) -> str:
    """What to type to have the choice done; writes the scene where --write asks for it."""
    way, options = chosen["way"], request["options"]
    scene, write = options["scene"], options["write"]
    has_own_tolerance = way.has_own_tolerance and way.tolerance != options["tolerance"]
    if not write and way.halvings == 0 and not has_own_tolerance:
        return f"    maille run {shlex.quote(scene)} --methods {way.method}\n"
    text = request["texts"][str(way.halvings)]["with_tolerance" if has_own_tolerance else "text"]
    if text is None:
        return "    no scene file says its lattice: finer ones are those of the scene's own cells, halved\n"
    file = write or str(Path(scene).with_name(Path(scene).stem + "_chosen.toml"))
    run = f"    maille run {shlex.quote(file)} --methods {way.method}\n"
    if write:
        text = text.replace(options["tolerance_mark"], repr(way.tolerance)) if has_own_tolerance else text
        write_whole(Path(file), f"# Made by maille study choose {request['maille']}.\n{text}")
        return f"wrote {file}\n{run}"
    of = "" if options["of"] == "displacement" else f" --of {options['of']}"
    return (f"    maille study choose {shlex.quote(scene)} --error {shlex.quote(options['error'])}{of} --time {shlex.quote(options['time'])} "
            f"--write {shlex.quote(file)}\n{run}")  # fmt: skip


def finish(request: Dict[str, Any]) -> int:
    """``maille study choose``: its tables alone, then all once the scene is probed. @return the exit code"""
    rows = read_trade_tables(request["tables"])
    if request["kind"] == "tables":  # nothing but their faults was asked
        return 0
    choice = choice_of(request, rows)
    how = "\nto do it:\n" + _how_to_do_it(request, choice["chosen"]) if choice["chosen"] else ""
    if request["json"] != "-":
        print_safely(choice_in_words(choice, request["title"]) + how)
    for candidate in choice["candidates"]:
        del candidate["way"]
    if request["json"]:
        deliver(in_json(choice), request["json"])
    return 0 if choice["chosen"] else 1


# For notebooks


def choose(scene: "Scene | str | os.PathLike[str]", error: float, time: float, *, of: str = "displacement", memory: Optional[int] = None,
           level: float = 0.95, tables: Sequence["str | os.PathLike[str]"] = (), threads: int = 1, progress: Progress = None) -> Dict[str, Any]:  # fmt: skip
    """The cheapest way that is expected to meet an error and a time on a scene, as ``study choose --json`` writes it.

    "chosen" is None where nothing is expected to meet both. Cost: about three times ``coupled`` on the finest lattice probed.
    Source: Lei and others 2018.

    Args:
        scene: a Scene, or a file
        error: relative: 0.05 is 5 %
        time: set-up and solve [s]
        of: what the error is of: "displacement", "force", "energy", "stress", or a measure of the scene
        memory: [bytes]; None: what is free
        level: how often the promise is kept, from 0 to 1
        tables: CSV files of ``study trade`` in place of the built-in one
        progress: as of ``Scene.run``

    Raises:
        TypeError: a faulty argument
        ValueError: a faulty value, or the command's message
        FileNotFoundError: the command is not installed
    """
    error, time, level = (number_above_0(*one) for one in (("error", error, "0.05"), ("time", time, "10"), ("level", level, "0.95")))
    threads, memory = count("threads", threads), memory if memory is None else count("memory", memory)
    with tempfile.TemporaryDirectory() as folder:
        words = ["study", "choose", *scene_files([scene], folder), "--error", f"{100 * error:.17g}%", "--time", f"{time:.17g}s", "--of", of,
                 "--level", repr(level), "--threads", str(threads), "--json", "-"]  # fmt: skip
        words += ["--memory", f"{memory}B"] if memory is not None else []
        words += ["--table", ",".join(os.fspath(table) for table in tables)] if tables else []
        with told(progress) as tell:
            ended = run(words, tell)
    if ended.is_interrupted:
        raise KeyboardInterrupt
    try:
        return dict(json.loads(ended.output))
    except ValueError:
        raise ValueError(ended.complaint or f"maille study choose ended with exit code {ended.code}") from None
