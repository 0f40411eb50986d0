"""A body in the hand, step by step: drag_in_the_hand.py [PICTURE.png]

Neighbour limits alone: a handle is moved, and as much of the body follows as has to. That costs microseconds, so that a hand may do it.
"""
import sys
import time

import matplotlib
import numpy as np

import maille

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

# A disc with a hole, one voxel thick; its links give by 20 %.
x, y = np.meshgrid(np.arange(48) - 23.5, np.arange(48) - 23.5, indexing="ij")
radius = np.hypot(x, y)
disc = ((radius < 23) & (radius > 9)).astype(np.uint8)[:, :, np.newaxis]
scene = maille.Scene(maille.Image(disc, material="muscle/soleus", fibre=(1, 0, 0)), holds=[maille.hold("x-")],
                     limits={"from": "given", "stretch": 1.2, "compress": 0.8, "shear": 0.2})
drag = scene.drag()

figure, axes = plt.subplots(1, 4, figsize=(11, 3.6), constrained_layout=True)
places, seconds = np.linspace(0, 1, 4), []
nx, ny, _ = scene.nodes
cells = np.argwhere(scene.material_id != 255)
for axis, t in zip(axes, places):
    begin = time.perf_counter()
    drag.move("x+", by=(0.012 * t, 0.008 * t, 0.0))
    seconds.append(time.perf_counter() - begin)
    u = 1e3 * drag.displacement                           # (ny, nx, 2): one voxel thick is two-dimensional
    px, py = np.arange(nx) + u[..., 0], np.arange(ny)[:, np.newaxis] + u[..., 1]
    far = np.linalg.norm(u, axis=-1)
    corners = [[(px[j + b, i + a], py[j + b, i + a]) for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))] for j, i in cells]
    painted = matplotlib.collections.PolyCollection(
        corners, array=np.array([far[j:j + 2, i:i + 2].mean() for j, i in cells]), cmap="magma", clim=(0, 14.5), linewidths=0)
    axis.add_collection(painted)
    axis.set(xlim=(-4, 64), ylim=(-4, 60), aspect="equal", title=f"hand at {14.4 * t:.1f} mm")
    axis.set_axis_off()
figure.colorbar(painted, ax=axes, label="displacement [mm]", shrink=0.8)
print(f"a step of the hand: {1e6 * np.median(seconds[1:]):.0f} us, {len(cells)} cells")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "drag_in_the_hand.png", dpi=110)
