"""Error against cost: which measured ways to answer a scene are worth having, in words and as a picture.

The command measures; ``docs/trade.md``. A row is on a front where no other is both cheaper and nearer (better in one,
not worse in the other); rows that are alike are all on it.
"""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Any, Callable, Dict, List, Optional, Sequence

import numpy as np
import numpy.typing as npt

from ._program import deliver, in_json, no_picture, print_safely
from ._words import in_bytes, in_percent, in_seconds, in_unit, table

Row = Dict[str, Any]


def pareto_front(cost: npt.ArrayLike, error: npt.ArrayLike) -> npt.NDArray[np.int64]:
    """Indices of the points that no other dominates (less in one, not more in the other), from the cheapest on, in O(n log n).

    Points that are alike are all included, those that are not finite never.
    """
    points = np.column_stack([np.asarray(cost, float), np.asarray(error, float)])
    order = np.lexsort((points[:, 1], points[:, 0]))
    order = order[np.isfinite(points[order]).all(axis=1)]
    cheapest: Dict[float, float] = {}  # the best error that each point of the front has, by its cost
    least = np.inf
    for cost_of, error_of in points[order]:
        if error_of < least:
            cheapest[cost_of] = least = error_of
    return np.array([i for i in order if cheapest.get(points[i, 0]) == points[i, 1]], dtype=int)


def mark_fronts(rows: List[Row]) -> None:
    """Sets "on_front" of rows as ``study trade --json`` has them: settled ones with an error alone can be on a front."""
    nan = float("nan")
    errors = [row["error"]["relative_l2"] if _has_error(row) else nan for row in rows]
    over_time = pareto_front([row["seconds"]["total"] if _has_error(row) else nan for row in rows], errors)
    over_memory = pareto_front([row.get("bytes") or nan for row in rows], errors)
    for i, row in enumerate(rows):
        row["on_front"] = {"time": i in over_time, "memory": i in over_memory}


def _has_error(row: Row) -> bool:
    return row["status"] in ("done", "clamped") and (row.get("error") or {}).get("relative_l2") is not None


def _front(row: Row) -> str:
    return ("t" if row["on_front"]["time"] else "") + ("m" if row["on_front"]["memory"] else "")


def _spacing(row: Row) -> str:
    factor: float = row["spacing_factor"]
    return f"{factor:g}" if factor >= 1 else f"1/{1 / factor:g}"


def _measured(value: Row) -> str:
    """One number; of a line its least and its most."""
    unit, why_not = str(value["unit"]), str(value.get("why_not", ""))
    if "line" in value:
        known = [point["value"] for point in value["line"] if point["value"] is not None]
        return f"{in_unit(min(known), unit)} to {in_unit(max(known), unit)}" if known else why_not
    return why_not if value["value"] is None else in_unit(value["value"], unit)


def _vector(value: Row) -> Optional[str]:
    vector: Optional[List[float]] = value.get("vector")
    if vector is None:
        return None
    largest = max(abs(part) for part in vector)
    return " (" + ", ".join(f"{part if abs(part) > 1e-7 * largest else 0:.4g}" for part in vector) + f") {value['unit']}"


def _measures_in_words(rows: Sequence[Row]) -> str:
    lines = []
    for row in rows:
        errors = (row.get("error") or {}).get("measures") or {}
        tolerance = f" to {row['tolerance']:g}" if row["tolerance"] is not None else ""
        for value in row.get("measures") or ():
            error = errors.get(value["name"])
            lines.append([value["name"], f"{row['method']} {_spacing(row)}{tolerance}", _measured(value),
                          None if error is None else in_percent(error), _vector(value)])  # fmt: skip
    if not lines:
        return ""
    names = list(dict.fromkeys(line[0] for line in lines))
    lines.sort(key=lambda line: names.index(line[0]))
    columns = [("measure", -16), ("method", -18), ("value", 24), ("error", 10), (" vector", 0)]
    shown = [i for i in range(5) if i < 3 or any(line[i] is not None for line in lines)]
    return "\n" + table([(*columns[i], lambda line, i=i: line[i]) for i in shown], lines)  # type: ignore[misc]


def trade_in_words(rows: Sequence[Row], everything: bool = False) -> str:
    """The rows of the fronts, "t" on that over time, "m" on that over memory; all where asked for, or none is on a front."""
    shown = [row for row in rows if _front(row)]
    if everything or not shown:
        shown = list(rows)

    def seconds(key: str) -> Callable[[Row], str]:
        return lambda row: in_seconds((row.get("seconds") or {}).get(key))

    text = "\n" + table([
        ("method", -9, lambda row: row["method"]), ("spacing", 7, _spacing), ("nodes", 9, lambda row: str(row.get("nodes") or "-")),
        ("tol.", 7, lambda row: None if row["tolerance"] is None else f"{row['tolerance']:g}"), ("status", -14, lambda row: row["status"]),
        ("set-up", 9, seconds("setup")), ("solve", 9, seconds("solve")), ("total", 9, seconds("total")),
        ("memory", 10, lambda row: in_bytes(row["bytes"]) if row.get("bytes") else None), ("iter.", 9, lambda row: str(row.get("iterations", "-"))),
        ("L2 error", 10, lambda row: in_percent((row.get("error") or {}).get("relative_l2"))),
        ("max error", 10, lambda row: in_percent((row.get("error") or {}).get("relative_max"))), ("front", 6, _front)], shown)  # fmt: skip
    if len(shown) < len(rows):
        text += f"{len(rows) - len(shown)} more rows, on no front: --all, or the files of --out\n"
    text += _measures_in_words(shown)
    text += "\nspacing: of the lattice over the scene's; front: nothing is both nearer and quicker (t), or both nearer and smaller (m)\n"
    for row in rows:
        if row.get("message") and row["status"] not in ("done", "clamped"):
            tolerance = f" to {row['tolerance']:g}" if row["tolerance"] is not None else ""
            text += f"{row['method']} at {_spacing(row)} times the spacing{tolerance}: {row['message']}\n"
    return text


def trade_figure(trade: Dict[str, Any]) -> Any:
    """Both fronts, over time and over memory, as a Matplotlib figure; None where no row has an error.

    @param trade  as ``study trade --json`` writes it
    """
    from ._plots import GREY, log_axis, look, new_figure, style

    rows = [row for row in trade["rows"] if _has_error(row) and row["error"]["relative_l2"] > 0 and row["seconds"]["total"] > 0]
    if not rows:
        return None
    floor = (trade.get("reference_error") or {}).get("relative_l2")
    with style():
        figure, axes = new_figure(11, 4.6, trade["title"], 1, 2, sharey=True)
        costs: List[Callable[[Row], float]] = [lambda row: 1e3 * float(row["seconds"]["total"]), lambda row: float(row.get("bytes") or 0) / 2**20]
        for axis, cost, front, label in zip(axes.flat, costs, ("time", "memory"), ("time [ms], set-up and solve", "memory [MiB]")):
            if floor:
                axis.axhline(100 * floor, color=GREY, linestyle="--", linewidth=1.5, label="reference's error")
            steps = sorted((cost(row), 100 * row["error"]["relative_l2"]) for row in rows if row["on_front"][front])
            axis.step(*np.reshape(steps, (-1, 2)).T, where="post", color="#444444", linewidth=1.5, label="front")
            for method in dict.fromkeys(row["method"] for row in rows):
                points = [(cost(row), 100 * row["error"]["relative_l2"]) for row in rows if row["method"] == method and cost(row) > 0]
                if points:
                    axis.plot(*np.transpose(points), linestyle="none", **look(method))
            axis.set_xlabel(label)
            log_axis(axis, "x")
        for axis in axes.flat:
            log_axis(axis, "y")
        axes[0, 0].set_ylabel("L2 error [%]")
        axes[0, 1].legend(loc="center left", bbox_to_anchor=(1, 0.5))
    return figure


def _csv_with_fronts(text: str, rows: Sequence[Row]) -> str:
    """The command's table with its column of fronts filled."""
    lines = list(csv.reader(io.StringIO(text)))
    column = lines[0].index("front")
    for line, row in zip(lines[1:], rows):
        line[column] = _front(row)
    stream = io.StringIO()
    csv.writer(stream, lineterminator="\n").writerows(lines)
    return stream.getvalue()


def finish(request: Dict[str, Any]) -> int:
    """``maille study trade`` once the rows are measured. @return the exit code"""
    trade = request["document"]
    mark_fronts(trade["rows"])
    text = _csv_with_fronts(request["csv_text"], trade["rows"])
    is_quiet = "-" in (request["json"], request["csv"])
    if not is_quiet:
        print_safely(request["head"] + trade_in_words(trade["rows"], request["all"]) + request["notes"])
    if request["json"]:
        deliver(in_json(trade), request["json"])
    if request["csv"]:
        deliver(text, request["csv"])
    if request["stem"]:
        written = _write_files(Path(request["stem"]), {**trade, **request["about"]}, text)
        if not is_quiet:
            print_safely("".join(f"wrote {file}\n" for file in written))
    return int(request["exit_code"])


def _write_files(stem: Path, trade: Dict[str, Any], text: str) -> List[Path]:
    from ._plots import save

    files = [stem.with_name(stem.name + ending) for ending in (".json", ".csv", ".svg", ".png")]
    deliver(in_json(trade), str(files[0]))
    deliver(text, str(files[1]))
    figure = trade_figure(trade) if trade["whole"] else None  # an interrupted command ends soon
    for file in files[2:] if figure is None else ():
        no_picture("no row has an error" if trade["whole"] else "the trade is not whole", file, is_kept=not trade["whole"])
    for file in files[2:] if figure is not None else ():
        save(figure, file)
    return files if figure is not None else files[:2]
