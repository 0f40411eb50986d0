"""How every plot of Maille looks, and how it becomes a file.

Colours are those that colour-blind readers tell apart (Wong 2011, Nature Methods 8, 441). A method has the same
colour and the same shape in every plot. Figures are Matplotlib's, without pyplot: the user's own settings and
figures are neither read nor changed. Texts of files are texts: "$" starts no formula, and control characters are
left out. The same figure gives the same bytes. Draw inside ``with style():``; ::

    with style():
        figure, axes = new_figure(10, 4.2, title="A beam", columns=2)
        axes[0, 0].plot(x, y, **look("coupled"))
        axes[0, 0].set(xlabel="time [s]", ylabel="force [N]")
        log_axis(axes[0, 0], "y")
        save(figure, Path("plot.svg"))
"""

from __future__ import annotations

import base64
import io
import logging
import warnings
from pathlib import Path
from typing import Any, Dict, Optional, Tuple

logging.getLogger("matplotlib").setLevel(logging.ERROR)  # it tells of its caches

import matplotlib
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter
from matplotlib.text import Text

import numpy as np

from ._program import UsageError, write_whole

GREY, DARK, LIGHT = "#7F7F7F", "#1b1f24", "#E4E4E4"
SEQUENTIAL, DIVERGING = "cividis", "PuOr"  # colour maps for values, and for values on two sides of zero

# method: colour, marker, whether the marker is filled
LOOKS: Dict[str, Tuple[str, str, bool]] = {
    "limits": ("#0072B2", "s", True),
    "literal": ("#56B4E9", "s", False),
    "sweep": ("#CC79A7", "^", False),
    "relaxed": ("#009E73", "^", True),
    "coupled": ("#D55E00", "o", True),
    "fem_q1": (GREY, "v", True),
    "fem_q2": (DARK, "D", True),
    "dijkstra": ("#B8A000", "X", True),
}

STYLE: Dict[str, Any] = {
    "font.family": "sans-serif", "font.sans-serif": ["DejaVu Sans"], "font.size": 10,
    "svg.hashsalt": "maille", "svg.fonttype": "none", "text.parse_math": False,
    "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True, "axes.axisbelow": True,
    "axes.titlesize": 10, "axes.linewidth": 0.8, "axes.unicode_minus": True, "axes.formatter.useoffset": False,
    "grid.color": LIGHT, "grid.linewidth": 0.8, "lines.linewidth": 1.6, "lines.markersize": 6,
    "legend.frameon": False, "legend.fontsize": 9, "figure.facecolor": "white", "figure.dpi": 100,
    "savefig.dpi": 100, "image.cmap": SEQUENTIAL,
}  # fmt: skip


def style() -> Any:
    """A context in which Matplotlib draws in Maille's style."""
    return matplotlib.rc_context({**matplotlib.rcParamsDefault, "backend": "agg", **STYLE})


def look(method: str, number: "int | None" = None) -> Dict[str, Any]:
    """Keywords of ``Axes.plot`` for a method: colour, marker, label.

    @param number  of a series that is no method (a force, a drive): it takes the look of that place; without
                   one it is brown
    """
    if method in LOOKS:
        colour, marker, is_filled = LOOKS[method]
    elif number is None:
        colour, marker, is_filled = "#8C564B", "P", True
    else:
        colour, marker, is_filled = list(LOOKS.values())[number % len(LOOKS)]
    return {"color": colour, "marker": marker, "label": method, "markerfacecolor": colour if is_filled else "white"}


def new_figure(width: float = 10, height: float = 4.2, title: str = "", rows: int = 1, columns: int = 1,
               **subplots: Any) -> "Tuple[Figure, Any]":  # fmt: skip
    """@param width, height  in inches; 100 pixels each. @return the figure, its axes (rows x columns)"""
    figure = Picture(figsize=(width, height), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **subplots)
    if title:
        figure.suptitle(title, fontsize=12)
    return figure, axes


def log_axis(axes: Any, which: str) -> None:
    """Makes the axis "x" or "y" logarithmic, with numbers as people write them (0.01, 1, 100).

    Where few decades are spanned, numbers stand between powers of ten too. Call it after plotting.
    """
    getattr(axes, f"set_{which}scale")("log")
    axis = getattr(axes, f"{which}axis")
    least, most = getattr(axes, f"get_{which}lim")()
    is_short = 0 < least < most < 1000 * least
    number = FuncFormatter(lambda value, _: f"{value:g}")
    axis.set_major_locator(LogLocator(subs=(1, 2, 5) if is_short else (1,)))
    axis.set_major_formatter(number)
    axis.set_minor_formatter(NullFormatter())


def unit_for(largest: float, unit: str) -> Tuple[float, str]:
    """A unit in which the largest value lies from 1 to 1000: ``unit_for(0.012, "m")`` is (1e-3, "mm")."""
    for factor, prefix in ((1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"), (1e-12, "p")):
        if largest >= factor:
            return factor, prefix + unit
    return 1.0, unit


class Picture(Figure):  # type: ignore[misc]
    """A figure that notebooks show without pyplot."""

    def _repr_png_(self) -> bytes:
        return bytes_of(self, "png")


_FIELDS = {"displacement": ("displacement", "m"), "von_mises": ("von Mises stress", "Pa"), "fibre_strain": ("fibre strain", "%"),
           "fibre_stress": ("fibre stress", "Pa"), "label": ("label", "")}  # fmt: skip


def slice_figure(answer: Any, field: Any, axis: Optional[int], at: Optional[int]) -> Figure:
    """See ``Answer.plot``. Points go where the two layers of nodes beside the slice go on average; colours are those of cells."""
    scene = answer.scene
    if scene.dimension == 1:
        raise ValueError("expected a body in two or three dimensions, found one in one")
    u = answer.in_frame("grid").displacement
    if isinstance(field, str) and field not in _FIELDS:
        raise ValueError(f"field: expected one of {', '.join(_FIELDS)} or an array of cells, found {field!r}")
    name, unit = _FIELDS[field] if isinstance(field, str) else ("", "")
    if name == "displacement":
        values = np.linalg.norm(u, axis=-1)
        for along in range(scene.dimension):  # of a cell the mean of its corners
            first, last = (np.take(values, range(begin, values.shape[along] - 1 + begin), along) for begin in (0, 1))
            values = (first + last) / 2
    else:
        values = getattr(answer, field) if isinstance(field, str) else np.asarray(field)
    matter = scene.material_id != 255
    if values is None or values.shape != matter.shape:
        raise ValueError(f"field: expected an array of cells, {matter.shape}, found {'none' if values is None else values.shape}")
    x, y = 0, 1
    if scene.dimension == 3:
        across = int(np.argmin(scene.cells)) if axis is None else axis
        x, y = (one for one in range(3) if one != across)
        middle = scene.cells[across] // 2 if at is None else at
        if not 0 <= middle < scene.cells[across]:
            raise ValueError(f"at: expected a cell from 0 to {scene.cells[across] - 1}, found {middle}")
        u = np.take(u, (middle, middle + 1), 2 - across).mean(axis=2 - across)
        values, matter = np.take(values, middle, 2 - across), np.take(matter, middle, 2 - across)
    places = [(scene.spacing[one] * np.arange(scene.nodes[one])) for one in (x, y)]
    across_page, up = (1e3 * (rest + u[..., one]) for rest, one in zip(np.meshgrid(*places), (x, y)))
    largest = float(np.abs(values[matter]).max()) if matter.any() else 0.0
    factor, unit = (0.01, "%") if unit == "%" else unit_for(largest, unit) if unit else (1.0, "")
    with style():
        figure = Picture(figsize=(8, 4.5), layout="constrained")
        axes = figure.subplots()
        drawn = axes.pcolormesh(across_page, up, np.where(matter, values / factor, np.nan), rasterized=True)
        axes.set(aspect="equal", title=f"{scene.title} by {answer.method}", xlabel=f"{'xyz'[x]} [mm]", ylabel=f"{'xyz'[y]} [mm]")
        axes.grid(False)
        figure.colorbar(drawn, ax=axes, label=f"{name} [{unit}]" if unit else name)
    return figure


def bytes_of(figure: Figure, kind: str = "svg") -> bytes:
    """The figure as SVG or PNG."""
    for text in figure.findobj(Text):
        text.set_text("".join(c if c.isprintable() or c == "\n" else "?" for c in text.get_text()))
    stream = io.BytesIO()
    with style(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph")  # a letter that this machine's fonts lack
        if kind == "svg":
            FigureCanvasSVG(figure).print_svg(stream, metadata={"Date": None, "Creator": "maille"})
        else:
            FigureCanvasAgg(figure).print_png(stream, metadata={"Software": "maille"})
    return stream.getvalue()


def save(figure: Figure, file: "str | Path") -> None:
    """Writes an .svg or .png file, whole or not at all.

    Raises:
        UsageError: an unknown file type
    """
    kind = Path(file).suffix
    if kind not in (".svg", ".png"):
        raise UsageError(f'picture: expected a file that ends in .svg or .png, found "{file}"')
    write_whole(Path(file), bytes_of(figure, kind[1:]))


def figure_as_data_uri(figure: Figure, kind: str = "svg") -> str:
    """The figure as the ``src`` of an image of HTML."""
    return data_uri("image/svg+xml" if kind == "svg" else "image/png", bytes_of(figure, kind))


def data_uri(kind: str, content: bytes) -> str:
    """``data:KIND;base64,...`` (RFC 2397)"""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"
