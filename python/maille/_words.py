"""Numbers in words, and tables for people, as all commands print them."""

from __future__ import annotations

import math
from typing import Any, Callable, Optional, Sequence, Tuple, Union

# heading, width (below 0: to the left; 0: the longest cell), cell of a row
Column = Tuple[str, int, Callable[[Any], Any]]


def in_percent(ratio: Optional[float]) -> str:
    return f"{100 * ratio:.3g} %" if ratio is not None and math.isfinite(ratio) else "-"


def in_seconds(seconds: Optional[float]) -> str:
    """In the unit that leaves a number from 1 to 1000."""
    if seconds is None or not math.isfinite(seconds):
        return "-"
    if seconds < 1e-3:
        return f"{1e6 * seconds:.3g} us"
    return f"{1e3 * seconds:.3g} ms" if seconds < 1 else f"{seconds:.3g} s"


def in_bytes(number: float) -> str:
    if number < 999.5:  # three digits must not become 1e+03
        return f"{number:.0f} byte{'' if round(number) == 1 else 's'}"
    for unit in ("KiB", "MiB", "GiB", "TiB"):
        number /= 1024
        if number < 999.5:
            return f"{number:.3g} {unit}"
    return f"{number:.0f} TiB"


def in_unit(value: float, unit: str) -> str:
    """A measured value (SI) in the unit that suits it; without a unit it is a ratio."""
    size = abs(value)
    if unit == "":
        return in_percent(value)
    if unit == "m":
        name, metres = ("m", 1) if size >= 1 - 1e-9 else ("mm", 1e-3) if size >= 0.99999e-5 or size == 0 else ("um", 1e-6) if size >= 0.99999e-6 else ("nm", 1e-9)
        return f"{value / metres:.4g} {name}"
    if unit == "Pa":
        name, pascals = ("GPa", 1e9) if size >= 1e9 else ("MPa", 1e6) if size >= 1e6 else ("kPa", 1e3) if size >= 1e3 else ("Pa", 1)
        return f"{value / pascals:.3g} {name}"
    if unit == "rad":
        return f"{math.degrees(value):.4g} deg"
    if unit in ("m^3", "m^2"):
        return f"{value * (1e9 if unit == 'm^3' else 1e6):.5g} m{unit}"
    return f"{value:.4g} {unit}"


def table(columns: Sequence[Column], rows: Sequence[Any]) -> str:
    """Lines of cells side by side under their headings; "-" where there is no value."""
    cells = [[heading for heading, _, _ in columns]]
    cells += [[cell(row) or "-" for _, _, cell in columns] for row in rows]
    widths = [width or -max(len(line[i]) for line in cells) for i, (_, width, _) in enumerate(columns)]
    if columns and columns[-1][1] == 0:
        widths[-1] = -1  # no blanks at the ends of lines
    return "".join(" ".join(f"{text:<{-width}}" if width < 0 else f"{text:>{width}}" for text, width in zip(line, widths)) + "\n"
                   for line in cells)  # fmt: skip


def upper_median(values: Sequence[Union[int, float]]) -> float:
    """Of two middle values the upper: a measured one."""
    return sorted(values)[len(values) // 2]
