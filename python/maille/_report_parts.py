"""What a page of results is made of: values of JSON files in words, cells of tables, plots.

A folder may hold anything. JSON is read up to a size and the interpreter's depth; a value is looked up by `at`, which gives None
where the file has another form. Nothing here is HTML: the template (templates/page.html) escapes every text.

A number that is rounding beside the largest of its kind (below 1e-6 of it) is shown as 0; the key that a table
sorts by stays what the file has.
"""

from __future__ import annotations

import json
import math
import re
from pathlib import Path, PurePath
from typing import Any, Callable, Dict, Iterable, List, Optional, Sequence, Tuple

from . import _words
from ._program import UsageError

Data = Dict[str, Any]
LARGEST_FILE = 64 << 20  #: [bytes] of one JSON file
NOISE = 1e-6
NONE = "–"


def parse(text: bytes, file: Path) -> Any:
    """Parses JSON.

    Raises:
        UsageError: no JSON, infinite numbers, or brackets nested too deeply
    """

    def refuse(what: str) -> Any:
        raise ValueError(f"{what[:30]} is no number of JSON")

    def number(digits: str) -> "int | float":
        value = float(digits)
        return (int(digits) if len(digits) < 16 and re.fullmatch(r"-?\d+", digits) else value) if math.isfinite(value) else refuse(digits)

    try:
        return json.loads(text, parse_constant=refuse, parse_int=number, parse_float=number)
    except (ValueError, RecursionError) as error:
        raise UsageError(f"{file}: expected JSON, found {error}") from None


def read(file: Path, largest: int = LARGEST_FILE) -> bytes:
    """Reads a file.

    Raises:
        UsageError: a larger file
    """
    with file.open("rb") as stream:
        content = stream.read(largest + 1)
    if len(content) > largest:
        raise UsageError(f"{file}: expected at most {in_bytes(largest)}, found more")
    return content


def at(data: Any, *keys: "str | int") -> Any:
    """``data[key][key]...``; None where there is no such entry."""
    for key in keys:
        if isinstance(data, dict):
            data = data.get(key)
        elif isinstance(data, list) and isinstance(key, int) and key < len(data):
            data = data[key]
        else:
            return None
    return data


def listed(data: Any, *keys: "str | int") -> List[Any]:
    """The list at that place; empty where there is none."""
    value = at(data, *keys)
    return value if isinstance(value, list) else []


def number(data: Any, *keys: "str | int") -> Optional[float]:
    value = at(data, *keys)
    return value if isinstance(value, (int, float)) and not isinstance(value, bool) else None


def words(data: Any, *keys: "str | int") -> str:
    """The text at that place; empty where there is none."""
    value = at(data, *keys)
    return value if isinstance(value, str) else ""


def plain(value: Any) -> str:
    if isinstance(value, str):
        return value
    if number(value) is None:
        return NONE
    return str(value) if isinstance(value, int) else f"{value:.6g}"


def said(form: str, unit: str = "", factor: float = 1) -> Callable[[Any], str]:
    """A function that writes a number so, and nothing as a dash."""
    return lambda value: NONE if number(value) is None else f"{factor * value:{form}}{unit}"


def _scaled(value: Any, steps: Sequence[Tuple[float, str]], form: str = ".3g") -> str:
    """In the first unit that is not larger than the value."""
    if number(value) is None:
        return NONE
    size, unit = next((step for step in steps if abs(value) >= step[0]), steps[-1])
    return f"{value / size:{form}} {unit}"


percent = said(".3g", " %", 100)


def seconds(value: Any) -> str:
    return "0 s" if value == 0 else _scaled(value, ((1, "s"), (1e-3, "ms"), (1e-6, "µs")))


def in_bytes(value: Any) -> str:
    return _words.in_bytes(value) if number(value) and value > 0 else NONE


def measured(value: Any, unit: str) -> str:
    """A measure in the unit that suits it. @param unit  of the file: SI, empty for a ratio"""
    if number(value) is None:
        return NONE
    text = _words.in_unit(value, unit)
    for ascii, sign in ((" um", " µm"), (" deg", "°"), ("m^2", "m²"), ("m^3", "m³")):
        text = text.replace(ascii, sign)
    return text


def pascals(value: Any) -> str:
    return measured(value, "Pa")


def clean(value: Any, largest: float) -> Any:
    """0 in place of rounding."""
    return 0 if number(value) is not None and abs(value) < NOISE * largest else value


def largest_of(values: Iterable[Any]) -> float:
    return max((abs(value) for value in values if number(value) is not None), default=0)


def length(vector: Any) -> float:
    return math.sqrt(sum(value * value for value in listed(vector) if number(value) is not None))


def cell(text: str, key: Any = None, is_number: bool = True) -> Data:
    """@param key  what the table sorts by"""
    if number(key) is None:
        return {"text": text, "is_number": is_number}
    return {"text": text, "is_number": is_number, "key": str(key) if isinstance(key, int) else f"{key:.9g}"}


def figure_cell(show: Callable[[Any], str], data: Any, *keys: "str | int") -> Data:
    return cell(show(at(data, *keys)), at(data, *keys))


def text_cell(text: str) -> Data:
    return {"text": text}


class Table:
    """Columns by name, and rows of as many cells."""

    def __init__(self, name: str, caption: str) -> None:
        self.id, self.caption = name, caption
        self.columns: List[Data] = []
        self.rows: List[Data] = []

    def add(self, *names: str, is_number: bool = True, why: str = "") -> None:
        self.columns += [{"name": name, "is_number": is_number, "why": why} for name in names]

    def append(self, cells: List[Data], is_reference: bool = False) -> None:
        self.rows.append({"is_reference": is_reference, "cells": cells})


def asked(about: Any) -> Data:
    """The scene's or the study's file, what `check --why` says of it, the command, and who made it, where a file has them."""
    scene = {"file": PurePath(words(about, "scene_file")).name, "text": words(about, "scene_text"), "explain": words(about, "explanation")}
    made_by = f"maille {words(about, 'maille')}, commit {words(about, 'commit')}" if words(about, "commit") else ""
    made_by += f", on {words(about, 'host')}, {words(about, 'date')}" if words(about, "host") else ""
    return {"scene": scene if scene["text"] else None, "command": words(about, "command"), "made_by": made_by}


def name_as_id(text: str) -> str:
    """Letters, digits and hyphens: an id of HTML."""
    return "id-" + "".join(c if c.isascii() and c.isalnum() else "-" for c in text)


def distinct(values: Iterable[Any]) -> List[Any]:
    """In order of first appearance."""
    return list(dict.fromkeys(values))


Series = Dict[str, List[Tuple[float, float]]]


def plot(series: Series, labels: Tuple[str, str], alt: str, caption: str, log: str = "", lines: bool = False) -> Data:
    """A plot of points by method.

    @param labels  of x and y, with units; log: the axes, of "xy", that are logarithmic
    """
    from . import _plots  # Matplotlib takes longer to load than a table to write

    with _plots.style():
        figure, ((axes,),) = _plots.new_figure(6.6, 3.7)
        for i, (name, points) in enumerate(series.items()):
            x, y = zip(*points)
            axes.plot(x, y, linestyle="-" if lines else "none", markersize=6 if len(x) < 100 else 3, **_plots.look(name, i))
        for which in log:
            _plots.log_axis(axes, which)
        axes.set(xlabel=labels[0], ylabel=labels[1])
        axes.legend(loc="upper left", bbox_to_anchor=(1.01, 1), borderaxespad=0)
        return {"source": _plots.figure_as_data_uri(figure), "look": "plot", "alt": alt, "caption": caption}
