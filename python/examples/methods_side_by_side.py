"""One question, three methods, and how far each is from elasticity: methods_side_by_side.py [PICTURE.png]

A strip of muscle with a stiff tendon in its middle is bent. The colour is how far each node is from where `coupled` has it.
"""
import sys

import matplotlib
import numpy as np

import maille

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

voxels = np.full((40, 12, 8), 1, dtype=np.uint8)
voxels[:, 5:7, 3:5] = 2
scene = maille.Scene(
    maille.Image(voxels, spacing="1 mm", fibre=(1, 0, 0),
                 labels={1: "muscle/vastus_lateralis", 2: {"youngs_modulus": "1 MPa", "poisson_ratio": 0.4}}),
    holds=[maille.hold("x-")], moves=[maille.move("x+", by=("1 mm", "3 mm", 0))])
compared = scene.compare(("limits", "relaxed"), reference="coupled")

figure, axes = plt.subplots(3, 1, figsize=(7.5, 7.5), sharex=True, constrained_layout=True)
truth = compared.answers["coupled"].displacement
rest = np.stack(np.meshgrid(np.arange(41.0), np.arange(13.0), indexing="xy"), axis=-1)
for axis, row in zip(axes, compared.rows):
    u = compared.answers[row["method"]].displacement
    middle = 1e3 * u[4, :, :, :2]                    # the layer in the middle, in mm: (ny, nx, 2)
    x, y = np.moveaxis(rest + middle, -1, 0)
    off = 1e3 * np.linalg.norm(u[4] - truth[4], axis=-1)
    painted = axis.pcolormesh(x, y, off, shading="gouraud", cmap="viridis", vmin=0, vmax=2)
    axis.plot(x[::3].T, y[::3].T, color="white", linewidth=0.4)
    axis.plot(x[:, ::4], y[:, ::4], color="white", linewidth=0.4)
    error = "reference" if row["method"] == "coupled" else f"{100 * row['relative_l2']:.0f} % off"
    axis.set_title(f"{row['method']}: {1e3 * row['seconds']:.1f} ms, {error}", loc="left", fontsize=10)
    axis.set_aspect("equal")
    axis.set_ylabel("y [mm]")
axes[-1].set_xlabel("x [mm]")
figure.colorbar(painted, ax=axes, label="distance from coupled [mm]", shrink=0.6)
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "methods_side_by_side.png", dpi=110)
