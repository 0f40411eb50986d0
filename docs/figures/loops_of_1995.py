"""Draws what the loops of 1995 make of one push, four moments of each. loops_of_1995.py [PICTURE.png]

Each of halving, sweep and hand_on plays studies/lab/scenes/world/handed_on.toml; the engines of the product do the same
with `maille play`. Needs maille-lab: cmake --preset release -DMAILLE_LAB=ON && cmake --build build/release --target maille_lab
"""
import os
import pathlib
import subprocess
import sys
import tempfile

import matplotlib

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
LABORATORY = os.environ.get("MAILLE_LAB", ROOT / "build/release/maille-lab")
SCENES = ROOT / "studies/lab/scenes/world"
LOOPS = {
    "halving": "a blocked step is halved; nothing is pushed",
    "sweep": "objects push; bodies relax node by node",
    "hand_on": "each voxel hands on what it cannot move",
}
MOMENTS = 4


def moments_of(loop, folder):
    """Four pictures of a play, evenly from the first frame to the last, with their numbers."""
    stem = pathlib.Path(folder) / loop
    subprocess.run([LABORATORY, "--loop", loop, SCENES / "handed_on.toml", SCENES / "handed_on_pushed.toml", stem], check=True)
    pictures = sorted(pathlib.Path(folder).glob(f"{loop}_*.png"))
    numbers = [round(i * (len(pictures) - 1) / (MOMENTS - 1)) for i in range(MOMENTS)]
    return [(number, plt.imread(pictures[number])) for number in numbers]


def main():
    target = sys.argv[1] if len(sys.argv) > 1 else "loops_of_1995.png"
    figure, axes = plt.subplots(len(LOOPS), MOMENTS, figsize=(14, 6.5), constrained_layout=True)
    with tempfile.TemporaryDirectory() as folder:
        for row, (loop, rule) in zip(axes, LOOPS.items()):
            for axis, (number, picture) in zip(row, moments_of(loop, folder)):
                axis.imshow(picture)
                axis.set_xlabel(f"frame {number}")
                axis.set_xticks([])
                axis.set_yticks([])
            row[0].set_title(f"{loop}: {rule}", loc="left", fontsize=10)
    figure.savefig(target, dpi=110)
    print(f"wrote {target}")


if __name__ == "__main__":
    main()
