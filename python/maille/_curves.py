"""Plots that a command wants in the middle of its work: forces over steps, what a hand felt over time, scales of pictures.

The command writes the request to this program's standard input, and gives it the name of a new file; it puts the
picture in place itself (studies/src/compare/plots.cpp).
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Dict, Sequence, Tuple

import numpy as np

from . import _plots


def force_figure(title: str, curves: Dict[str, Sequence[Tuple[float, Any, Any]]], what: str, per_metre: str = "") -> Any:
    """The size of a force, and the strain energy, over the largest displacement; from the body at rest on.

    @param curves  by method: displacement [m], force [N] and energy [J] of each step; None where unknown
    @param what    "force on moves"; per_metre: "/m" in two dimensions
    """
    figure, axes = _plots.new_figure(10, 4.2, title=title, columns=2)
    points = {method: np.array([(0.0, 0.0, 0.0), *curve], dtype=float) for method, curve in curves.items()}
    for i, (name, unit) in enumerate(((what, "N"), ("strain energy", "J")), start=1):
        known = {method: of[np.isfinite(of[:, i])] for method, of in points.items() if np.isfinite(of[1:, i]).any()}
        (along, metres), (up, unit) = (_plots.unit_for(max(float(of[:, c].max()) for of in known.values()), u) for c, u in ((0, "m"), (i, unit)))
        ax = axes[0, i - 1]
        for number, (method, of) in enumerate(known.items()):
            # Where two methods agree, the larger point of the first looks out from behind.
            ax.plot(of[:, 0] / along, of[:, i] / up, markersize=6 if number else 9, **_plots.look(method))
        ax.set(xlabel=f"largest displacement [{metres}]", ylabel=f"{name} [{unit}{per_metre}]", xlim=(0, None), ylim=(0, None))
    axes[0, 0].legend(loc="upper left")
    return figure


def hand_figure(title: str, samples: Sequence[Sequence[float]]) -> Any:
    """@param samples  a row a tick: time [s], force on the hand x, y, z [N], latency [us]"""
    time, x, y, z, latency = np.array(samples, dtype=float).reshape(-1, 5).T
    figure, axes = _plots.new_figure(11, 6.2, title=title, rows=2, sharex=True)
    # Behind the component that it is all of.
    axes[0, 0].plot(time, np.sqrt(x * x + y * y + z * z), color="#C8C8C8", linewidth=4, label="size")
    for of, name, method in ((x, "x", "limits"), (y, "y", "relaxed"), (z, "z", "coupled")):
        axes[0, 0].plot(time, of, color=_plots.LOOKS[method][0], linewidth=1.2, label=name)
    axes[0, 0].set_ylabel("force on the hand [N]")
    axes[0, 0].legend(loc="upper left", bbox_to_anchor=(1.01, 1), borderaxespad=0)
    ax = axes[1, 0]
    ax.plot(time, np.where(latency > 0, latency, np.nan), ".", color=_plots.GREY, markersize=1.5, rasterized=True, label="of a tick")
    ax.axhline(1000, color=_plots.LOOKS["coupled"][0], linestyle="--", label="1 ms")
    _plots.log_axis(ax, "y")
    ax.set(xlabel="time [s]", ylabel="latency [µs]")
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1), borderaxespad=0)
    return figure


def captioned_figure(title: str, picture: str, label: str, largest: float, colours: Sequence[Sequence[float]]) -> Any:
    """A picture, its pixels as they are, with its title above and a scale of its colours from 0 below.

    @param picture  a PNG; colours: red, green and blue from 0 to 1, equally spaced
    """
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LinearSegmentedColormap, Normalize
    from matplotlib.image import imread

    pixels = imread(picture)
    (height, width), em = pixels.shape[:2], max(9, pixels.shape[1] // 45)
    page = height + 7 * em
    figure = _plots.Picture(figsize=((width + 1e-6) / 100, (page + 1e-6) / 100))
    figure.figimage(pixels, 0, 4 * em)
    figure.text(0.5, 1 - 0.7 * em / page, title, fontsize=0.85 * em, ha="center", va="top")
    bar = figure.colorbar(ScalarMappable(Normalize(0, largest), LinearSegmentedColormap.from_list("field", list(colours))),
                          cax=figure.add_axes((0.15, 2.6 * em / page, 0.7, 0.8 * em / page)), orientation="horizontal")
    bar.set_label(label, fontsize=0.65 * em, labelpad=1)
    bar.ax.tick_params(labelsize=0.6 * em, length=0.2 * em, pad=1)
    return figure


def main(request: Dict[str, Any]) -> int:
    out = Path(request.pop("out"))
    draw: Any = hand_figure if "samples" in request else captioned_figure if "picture" in request else force_figure
    with _plots.style():
        out.write_bytes(_plots.bytes_of(draw(**request), out.suffix[1:]))
    return 0
