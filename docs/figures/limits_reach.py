"""Draws docs/limits_reach.png: what `limits` moves, and that it is plastic. limits_reach.py [PICTURE.png]

Left: the middle of a strip's upper edge is lifted, by limits and by coupled elasticity. Right: a chain, pulled and pushed back.
"""
import pathlib
import sys

import matplotlib
import numpy as np

import maille

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

NX, NY = 48, 16
LIMITS = {"from": "given", "stretch": 1.2, "compress": 0.8, "shear": 0.2}


def lifted():
    """The same lift, by limits and by elasticity."""
    scene = maille.Scene(maille.box((NX, NY), "1 mm", {"youngs_modulus": "10 kPa", "poisson_ratio": 0.3}), holds=[maille.hold("y-")],
                         moves=[maille.move({"box": [["22 mm", "16 mm"], ["26 mm", "16 mm"]]}, by=(0, "2.4 mm"))], limits=LIMITS)
    return {"limits": scene.run("limits"), "coupled": scene.with_values({"limits": {"from": "none"}}).run("coupled")}


def draw_lifted(axes):
    for axis, (method, answer) in zip(axes, lifted().items()):
        u = 1e3 * answer.displacement
        x, y = np.meshgrid(np.arange(NX + 1.0), np.arange(NY + 1.0))
        moved = np.linalg.norm(u, axis=-1)
        x, y = x + u[..., 0], y + u[..., 1]
        painted = axis.pcolormesh(x, y, moved, shading="gouraud", cmap="viridis", vmin=0, vmax=2.4)
        axis.plot(x[::2].T, y[::2].T, color="white", linewidth=0.4)
        axis.plot(x[:, ::2], y[:, ::2], color="white", linewidth=0.4)
        still = np.mean(moved < 1e-9)
        axis.set_title(f"{method}: {100 * still:.0f} % of the nodes stay where they are", loc="left", fontsize=10)
        axis.set_aspect("equal")
        axis.set_ylabel("y [mm]")
    axes[-1].set_xlabel("x [mm]")
    plt.colorbar(painted, ax=axes, label="displacement [mm]", shrink=0.7)


def draw_chain(axis):
    """Five nodes, four links of length 1 that may stretch and shorten by half."""
    scene = maille.Scene(maille.box((4,), "1 m", {"youngs_modulus": "1 kPa", "poisson_ratio": 0.0}), holds=[maille.hold("x-")],
                         limits={"from": "given", "stretch": 1.5, "compress": 0.5, "shear": 0.5})
    drag = scene.drag()
    states = []
    for by, words in ((0.0, "at rest"), (1.0, "pulled by 1"), (2.0, "by 2"), (1.0, "back to 1"), (0.0, "back to 0")):
        drag.move("x+", by=(by, 0.0, 0.0))
        states.append((words, np.arange(5.0) + drag.displacement[..., 0].ravel()))
    for row, (words, x) in enumerate(states):
        axis.plot(x, np.full(5, -row), "-o", color="#30678d" if row < 3 else "#c8643c", markersize=6)
        axis.text(-0.3, -row, words, ha="right", va="center", fontsize=9)
    axis.set_xlim(-2.4, 6.4)
    axis.set_ylim(-4.6, 0.6)
    axis.set_yticks([])
    axis.set_title("a chain, pulled and pushed back: nothing brings nodes home", loc="left", fontsize=10)
    axis.set_xlabel("place of the nodes [lengths of a link]")


figure = plt.figure(figsize=(12, 5.2), constrained_layout=True)
left, right = figure.subfigures(1, 2, width_ratios=[1.15, 1])
draw_lifted(left.subplots(2, 1, sharex=True))
draw_chain(right.subplots())
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent / "limits_reach.png", dpi=100)
