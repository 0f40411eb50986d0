"""What pulling costs, by the angle of the fibres: stiffness_study.py [PICTURE.png]

A study varies keys of the scene; the command runs it, and its records are what pandas reads.
"""
import sys

import matplotlib
import numpy as np

import maille

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

tissues = {"muscle/vastus_lateralis": "vastus lateralis", "muscle/soleus": "soleus", "muscle/gastrocnemius": "gastrocnemius"}
angles = list(range(0, 91, 10))
scene = maille.Scene(
    maille.box((24, 8, 8), "1 mm", "muscle/soleus", fibre={"angle": "0 deg", "plane": "xy"}),
    holds=[maille.hold("x-")], moves=[maille.move("x+", by=("1.2 mm", 0, 0))],
    measures=[maille.measure("pull", force="move[1]", component="x")])
rows = scene.study({"specimen.material": list(tissues), "specimen.fibre.angle": [f"{angle} deg" for angle in angles]})

figure, axis = plt.subplots(figsize=(6.5, 4.2), constrained_layout=True)
for tissue, words in tissues.items():
    forces = [1e3 * row["pull"] for row in rows if row["specimen.material"] == tissue]
    axis.plot(angles, forces, marker="o", label=words)
axis.set_xlabel("angle between fibres and pull [degrees]")
axis.set_ylabel("force for 5 % strain [mN]")
axis.set_ylim(bottom=0)
axis.grid(alpha=0.3)
axis.legend(frameon=False)
print(f"{len(rows)} cases, {np.sum([row['total_s'] for row in rows]):.2f} s")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "stiffness_study.png", dpi=110)
