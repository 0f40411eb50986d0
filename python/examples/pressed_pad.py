"""A finger presses a pad, frame by frame: pressed_pad.py [PICTURE.png]"""
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
cells   = [40, 40, 24]
spacing = "1 mm"
[[object]]
name  = "floor"
kind  = "fixed"
shape = "box"
cells = [40, 40, 4]
[[object]]
name     = "pad"
kind     = "deformable"
shape    = "box"
cells    = [24, 24, 8]
spacing  = "1 mm"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
hold     = [{ where = "z-" }]
limits   = { from = "given", stretch = 1.5, compress = 0.5, shear = 0.5 }
position = ["8 mm", "8 mm", "5 mm"]
[[object]]
name     = "finger"
kind     = "rigid"
shape    = "ellipsoid"
cells    = [8, 8, 8]
spacing  = "1 mm"
position = ["16 mm", "16 mm", "14 mm"]
"""

with tempfile.TemporaryDirectory() as folder:
    file = pathlib.Path(folder) / "pressed.toml"
    file.write_text(WORLD)
    world = maille.World(file)
depths, sunk, frames = [], [], []
for frame in range(1, 13):
    world.advance([maille.drive("finger", by=(0, 0, "-0.4 mm"))])
    u = world.displacement("pad")
    depths.append(0.4 * frame)
    sunk.append(-1e3 * u[..., 2].min())
    frames.append(1e3 * u[-1, 12, :, 2])             # along the middle of the upper face

figure, (left, right) = plt.subplots(1, 2, figsize=(9.5, 3.6), constrained_layout=True)
for n in range(1, 12, 2):
    left.plot(np.arange(25), frames[n], color=plt.cm.viridis(n / 12), label=f"{depths[n]:.1f} mm")
left.set(xlim=(-8, 25), xlabel="x along the pad [mm]", ylabel="upper face [mm]", title="profiles")
left.legend(title="finger down by", fontsize=8, title_fontsize=8, frameon=False, loc="lower left")
right.plot(depths, sunk, marker="o")
right.set(xlabel="finger down by [mm]", ylabel="deepest place [mm]", title="contact")
for axis in (left, right):
    axis.grid(alpha=0.3)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "pressed_pad.png", dpi=110)
