"""Both calves from MRI, deformed, and their muscles drawn over the scan: calf_over_the_scan.py [PICTURE.png]

Needs the folder calf_mri in $MAILLE_DATA: labels.nii.gz (which muscle a voxel is) and water.nii.gz (the scan). Labels and scan are of two
series of one volunteer, and lie some millimetres apart.
"""
import os
import sys

import matplotlib
import nibabel as nib
import numpy as np

import maille

matplotlib.use("Agg")
from matplotlib import pyplot as plt  # noqa: E402

folder = os.path.join(os.environ["MAILLE_DATA"], "calf_mri")
labels = nib.load(os.path.join(folder, "labels.nii.gz"))
scan = nib.load(os.path.join(folder, "water.nii.gz"))
# The header of this scan has the signs of its origin turned round: where it says it is, there are no labels.
placed = scan.affine.copy()
placed[:3, 3] *= -1
scan = nib.Nifti1Image(np.asarray(scan.dataobj), placed)

muscles = {label: "muscle/gastrocnemius" for label in range(13, 27)}
muscles[17] = muscles[18] = "muscle/soleus"
scene = maille.Scene(
    maille.Image(np.asarray(labels.dataobj), affine=labels.affine, labels=muscles, fibre=(0, 0, 1)),
    holds=[maille.hold("z+")], moves=[maille.move("z-", by=("12 mm", 0, "4 mm"))])   # within the image: the rest of it is not seen
print("\n".join(scene.check().warnings))
answer = scene.run("coupled")
warped, warped_scan = answer.warp(labels), answer.warp(scan)
for row in answer.warped_labels():
    print(f"label {row['label']}: {1e6 * row['volume_at_rest']:.1f} ml at rest, {1e6 * row['sub_voxel_volume']:.1f} ml now")


def slice_of(image, z):
    """A slice of the world at z [mm], on pixels of 1.5 mm, seen from above, left of the picture is the patient's left."""
    values, back = np.asarray(image.dataobj), np.linalg.inv(image.affine)
    x, y = np.meshgrid(np.arange(-225, 225, 1.5), np.arange(-75, 90, 1.5), indexing="ij")
    index = np.stack([x, y, np.full_like(x, z), np.ones_like(x)], axis=-1) @ back.T
    i, j, k = (np.clip(np.rint(index[..., a]).astype(int), 0, values.shape[a] - 1) for a in range(3))
    return np.where((index[..., :3] > -0.5).all(axis=-1), values[i, j, k], 0).T


figure, axes = plt.subplots(2, 1, figsize=(9, 7.2), facecolor="black")
for axis, grey, after, words in ((axes[0], scan, labels, "the scan and its labels"),
                                 (axes[1], warped_scan, warped, "deformed: the lower end moved by 12 mm aside, 4 mm up")):
    here = slice_of(after, -40)
    axis.imshow(slice_of(grey, -40), cmap="gray", origin="lower", vmin=0, vmax=400, extent=(-225, 225, -75, 90))
    for label in muscles:
        axis.contour(here == label, levels=[0.5], colors=[plt.cm.tab20(label % 20)], linewidths=1.2, origin="lower",
                     extent=(-225, 225, -75, 90))
    axis.set_title(words, color="white", fontsize=11)
    axis.set_axis_off()
figure.tight_layout()
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "calf_over_the_scan.png", dpi=110, facecolor="black")
