"""Draws docs/contact_laws.png: a disc pressed into a block, kept apart by cells and by surfaces. contact_laws.py [PICTURE.png]"""
import pathlib
import sys
import tempfile

import matplotlib
import numpy as np

import maille

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

WORLD = """
[world]
cells   = [40, 32]
spacing = "1 mm"
contact = "{contact}"
[[object]]
name     = "block"
kind     = "deformable"
shape    = "box"
cells    = [32, 14]
material = {{ youngs_modulus = "10 kPa", poisson_ratio = 0.3 }}
hold     = [{{ where = "y-" }}]
position = ["4 mm", "1 mm"]
[[object]]
name     = "disc"
kind     = "rigid"
shape    = "ellipsoid"
cells    = [14, 14]
position = ["13 mm", "16.02 mm"]
{surface}
"""
LAWS = {"cells": ("cells", ""), "surfaces": ("surfaces", ""), "surfaces, smooth disc": ("surfaces", 'surface  = "smooth"')}
STEP, FRAMES = 0.15, 27  # mm, down to 4 mm


def pressed(contact, surface):
    """The block's shape at the end, the disc's way, and the force that it needs, frame by frame."""
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "pressed.toml"
        file.write_text(WORLD.format(contact=contact, surface=surface))
        world = maille.World(file)
    depth, force = [0.0], [0.0]
    for _ in range(FRAMES):
        frame = world.advance([maille.drive("disc", by=(0, f"{-STEP} mm", 0))])
        depth.append(depth[-1] + STEP)
        force.append(abs(frame.drives[0]["force"][1]))
    return 1e3 * world.displacement("block"), depth, force


figure, axes = plt.subplots(1, 3, figsize=(13, 4.2), constrained_layout=True, width_ratios=[1, 1, 0.9])
for number, (name, law) in enumerate(LAWS.items()):
    u, depth, force = pressed(*law)
    axes[2].plot(depth, force, marker="o", markersize=3, label=name)
    if number == 2:
        continue
    axis = axes[number]
    x, y = np.meshgrid(np.arange(33.0), np.arange(15.0))
    x, y = 4 + x + u[..., 0], 1 + y + u[..., 1]
    axis.plot(x.T, y.T, color="#30678d", linewidth=0.7)
    axis.plot(x, y, color="#30678d", linewidth=0.7)
    for row in range(14):
        for column in range(14):
            if (row - 6.5) ** 2 + (column - 6.5) ** 2 <= 49:
                corner = (13 + column, 16.02 - STEP * FRAMES + row)
                axis.add_patch(plt.Rectangle(corner, 1, 1, facecolor="#e8c9b8", edgecolor="#c8643c", linewidth=0.5))
    axis.set(xlim=(4, 36), ylim=(0, 24), xlabel="x [mm]", ylabel="y [mm]")
    axis.set_title(f'contact = "{name}"', loc="left", fontsize=10)
    axis.set_aspect("equal")
axes[2].set(xlabel="disc down by [mm]", ylabel="force of the hand [N/m]")
axes[2].set_title("what the hand feels", loc="left", fontsize=10)
axes[2].legend(frameon=False, fontsize=9)
axes[2].grid(alpha=0.3)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else pathlib.Path(__file__).resolve().parent.parent / "contact_laws.png", dpi=100)
