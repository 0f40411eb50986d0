"""Draws docs/frames_bent.png: a bar whose end is turned, in the object's frame and in a frame for every cell. frames_bent.py [PICTURE.png]"""
import math
import pathlib
import sys

import matplotlib
import numpy as np

import maille

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

NX, NY, LENGTH = 32, 8, 0.032


def bent(frame, degrees):
    """The end is turned and put onto the arc of a circle along which the bar keeps its length."""
    angle = math.radians(degrees)
    end = (LENGTH * math.sin(angle) / angle, LENGTH * (1 - math.cos(angle)) / angle)
    scene = maille.Scene(maille.box((NX, NY), "1 mm", {"youngs_modulus": "10 kPa", "poisson_ratio": 0.3}), holds=[maille.hold("x-")],
                         moves=[maille.move("x+", by=(end[0] - LENGTH, end[1]), turn={"angle": angle, "about": (LENGTH, 0.004, 0)})],
                         relaxation={"frame": frame}, units="m, rad")
    return scene.run("coupled")


figure, axes = plt.subplots(2, 2, figsize=(11, 5.6), sharex=True, sharey="row", constrained_layout=True, height_ratios=[1, 1.9])
for row, degrees in enumerate((30, 90)):
    for axis, frame in zip(axes[row], ("object", "blocks")):
        answer = bent(frame, degrees)
        u = 1e3 * answer.displacement
        x, y = np.meshgrid(np.arange(NX + 1.0), np.arange(NY + 1.0))
        x, y = x + u[..., 0], y + u[..., 1]
        # Along the bar, in the middle of each cell: what the body believes its strain to be.
        painted = axis.pcolormesh(x, y, 100 * answer.strain[..., 0], cmap="RdBu_r", vmin=-25, vmax=25, edgecolors="#777777", linewidth=0.2)
        arc = np.linspace(0, math.radians(degrees), 60)
        radius = 1e3 * LENGTH / math.radians(degrees)
        axis.plot(radius * np.sin(arc), 4 + radius * (1 - np.cos(arc)), "k--", linewidth=1)
        axis.set_title(f'frame = "{frame}", {degrees} degrees: {1e3 * answer.strain_energy:.1f} mJ/m', loc="left", fontsize=10)
        axis.set_aspect("equal")
axes[1][0].set_xlabel("x [mm]")
axes[1][1].set_xlabel("x [mm]")
figure.colorbar(painted, ax=axes, label="strain along the first axis [%]", shrink=0.7)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent / "frames_bent.png", dpi=100)
