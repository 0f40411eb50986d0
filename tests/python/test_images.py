"""Images in and out, with nibabel: the 20 lines that the module was made for."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import maille
from conftest import AFFINE, label_scene, two_labels

nib = pytest.importorskip("nibabel")

TWENTY_LINES = Path(__file__).with_name("twenty_lines.py")


def test_round_trip_contract_the_twenty_lines_run(tmp_path):
    labels = np.zeros((10, 10, 16), dtype=np.int16)
    labels[2:8, 2:8, 2:14] = 17
    nib.save(nib.Nifti1Image(labels, AFFINE), tmp_path / "labels.nii.gz")
    environment = {**os.environ, "PYTHONPATH": os.environ["MAILLE_PYTHON_PATH"]}
    run = subprocess.run([sys.executable, str(TWENTY_LINES)], cwd=tmp_path, env=environment, capture_output=True,
                         text=True)
    assert run.returncode == 0, run.stderr
    assert run.stdout.startswith("done")
    warped = nib.load(tmp_path / "labels_warped.nii.gz")
    assert warped.shape == labels.shape and np.array_equal(warped.affine, nib.load(tmp_path / "labels.nii.gz").affine)
    assert set(np.unique(np.asarray(warped.dataobj))) == {0, 17}
    field = nib.load(tmp_path / "pull.nii.gz")
    assert field.shape == (10, 10, 16, 1, 3) and int(field.header["intent_code"]) == 1007
    assert (tmp_path / "soleus.toml").exists() and (tmp_path / "soleus_labels.nii.gz").exists()


def test_types_contract_mypy_strict_has_nothing_to_say():
    """mypy_strict_errors: of the twenty lines, and of the module itself."""
    pytest.importorskip("mypy")
    package = Path(os.environ["MAILLE_PYTHON_PATH"])
    environment = {**os.environ, "MYPYPATH": str(package)}
    run = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--config-file",
                          str(TWENTY_LINES.with_name("mypy.ini")), "--cache-dir", os.devnull,
                          "--follow-imports", "silent", str(TWENTY_LINES), str(package / "maille")],
                         env=environment, capture_output=True, text=True)
    errors = [line for line in run.stdout.splitlines() if ": error:" in line]
    print({"name": "mypy_strict_errors", "value": len(errors), "goal": 0})
    assert not errors and run.returncode == 0, run.stdout + run.stderr


def shifted(by):
    """A body that is moved as a whole, by voxels of its own grid."""
    labels = two_labels()
    step = AFFINE[:3, :3] @ by
    spacing = np.linalg.norm(AFFINE[:3, :3], axis=0)
    move = [float(1e-3 * n * s) for n, s in zip(by, spacing)]
    scene = maille.Scene(maille.Image(labels, affine=AFFINE, material="muscle/soleus", fibre=(1, 0, 0)),
                         moves=[maille.move({"box": [[-1, -1, -1], [1, 1, 1]]}, by=move)], units="m")
    return labels, scene.run("coupled"), step


def test_warps_analytic_a_body_moved_by_whole_voxels_is_its_array_moved():
    labels, answer, step = shifted((1, -1, 1))
    expected = np.zeros_like(labels)
    expected[2:8, 0:5, 2:6] = labels[1:7, 1:6, 1:5]
    image = nib.Nifti1Image(labels, AFFINE)
    warped = answer.warp(image)
    assert isinstance(warped, nib.Nifti1Image)
    assert np.array_equal(np.asarray(warped.dataobj), expected)
    assert np.array_equal(answer.warp(labels), expected)
    grey = answer.warp(labels.astype(np.float32) * 1.5, background=-1)
    assert np.array_equal(grey, np.where(expected != 0, 1.5 * expected, -1))
    rows = answer.warped_labels()
    assert [row["label"] for row in rows] == [5, 17]
    assert np.array(rows[0]["centroid"]) - rows[0]["centroid_at_rest"] == pytest.approx(1e-3 * step)
    assert rows[0]["volume"] == pytest.approx(rows[0]["integral_of_det_f"])
    far = AFFINE.copy()
    far[:3, 3] += 1e4
    with pytest.raises(ValueError, match="meets the body"):
        answer.warp(nib.Nifti1Image(labels, far))


def test_transforms_analytic_are_the_motion_in_lps_millimetres(tmp_path):
    _, answer, step = shifted((1, -1, 1))
    answer.save_transform(tmp_path / "pull.nii.gz")
    field = np.asarray(nib.load(tmp_path / "pull.nii.gz").dataobj)
    assert field[3, 3, 3, 0] == pytest.approx([step[0], step[1], -step[2]], rel=1e-5)  # minus, and x and y turned round
    answer.save_transform(tmp_path / "push.nrrd", forward=True)
    assert b"displacement field type:=modeling" in (tmp_path / "push.nrrd").read_bytes()[:1000]
    with pytest.raises(ValueError, match="nrrd"):
        answer.save_transform(tmp_path / "push.nii.gz", forward=True)


def test_warps_contract_what_does_not_fit_is_said():
    answer = label_scene(two_labels()).run()
    with pytest.raises(ValueError, match="expected an array of the scene's own grid"):
        answer.warp(np.zeros((3, 3, 3)))
    box = maille.Scene(maille.box((2, 2, 2), "1 mm", "muscle/soleus"), holds=[maille.hold("x-")]).run()
    with pytest.raises(ValueError, match="expected an image whose grid is meant"):
        box.save_transform("nowhere.nii.gz")


def bent():
    """A block of two labels on an oblique grid, moved 9 mm and more, and bent."""
    labels = np.zeros((26, 24, 18), dtype=np.uint8)
    labels[6:18, 6:12, 5:13] = 17
    labels[6:18, 12:18, 5:13] = 5
    affine = np.array([[-1.9, 0.7, 0, 40], [0.7, 1.9, 0, -35], [0, 0, 3, 5], [0, 0, 0, 1.0]])
    scene = maille.Scene(maille.Image(labels, affine=affine, labels={17: "muscle/soleus", 5: "muscle/soleus"}, fibre=(1, 0, 0)),
                         moves=[maille.move("x-", by=("6 mm", "3 mm", "4 mm")),
                                maille.move("x+", by=("6 mm", "9 mm", "4 mm"))])
    return labels, affine, scene.run("coupled")


def written(tmp_path):
    labels, affine, answer = bent()
    nib.save(nib.Nifti1Image(labels, affine), tmp_path / "labels.nii.gz")
    for ending in ("nii.gz", "mha", "nrrd"):
        answer.save_transform(tmp_path / f"pull.{ending}")
    expected = answer.warp(labels)
    assert (expected != labels).sum() > 1000 and set(np.unique(expected)) == {0, 5, 17}
    return labels, expected


@pytest.mark.parametrize("ending", ["nii.gz", "mha", "nrrd"])
def test_transforms_independent_plastimatch_warps_labels_as_we_do(tmp_path, ending):
    """Truth: plastimatch, another project's program."""
    if shutil.which("plastimatch") is None:
        pytest.skip("plastimatch is not installed")
    _, expected = written(tmp_path)
    subprocess.run(["plastimatch", "warp", "--input", "labels.nii.gz", "--xf", f"pull.{ending}", "--interpolation", "nn",
                    "--output-img", "out.nii.gz"], cwd=tmp_path, check=True, stdout=subprocess.DEVNULL)
    theirs = np.asarray(nib.load(tmp_path / "out.nii.gz").dataobj)
    # A middle that a face goes through may fall to either side.
    assert (theirs != expected).sum() <= 0.002 * (expected != 0).sum()


@pytest.mark.parametrize("ending", ["nii.gz", "mha"])
def test_transforms_independent_transformix_warps_labels_as_we_do(tmp_path, ending):
    """Truth: elastix, another project's program."""
    if shutil.which("transformix") is None:
        pytest.skip("elastix is not installed")
    labels, expected = written(tmp_path)
    affine = np.diag([-1.0, -1, 1, 1]) @ nib.load(tmp_path / "labels.nii.gz").affine
    direction, origin = affine[:3, :3], affine[:3, 3]
    spacing = np.linalg.norm(direction, axis=0)
    numbers = lambda values: " ".join(repr(float(v)) for v in values)  # noqa: E731
    (tmp_path / "transform.txt").write_text(f"""
(Transform "DeformationFieldTransform")
(NumberOfParameters 0)
(InitialTransformParametersFileName "NoInitialTransform")
(HowToCombineTransforms "Compose")
(DeformationFieldFileName "{tmp_path}/pull.{ending}")
(DeformationFieldInterpolationOrder 0)
(FixedImageDimension 3)
(MovingImageDimension 3)
(FixedInternalImagePixelType "float")
(MovingInternalImagePixelType "float")
(Size {labels.shape[0]} {labels.shape[1]} {labels.shape[2]})
(Index 0 0 0)
(Spacing {numbers(spacing)})
(Origin {numbers(origin)})
(Direction {numbers((direction / spacing).T.ravel())})
(UseDirectionCosines "true")
(ResampleInterpolator "FinalBSplineInterpolator")
(FinalBSplineInterpolationOrder 0)
(Resampler "DefaultResampler")
(DefaultPixelValue 0)
(ResultImageFormat "nii.gz")
(ResultImagePixelType "unsigned char")
""")
    subprocess.run(["transformix", "-in", "labels.nii.gz", "-tp", "transform.txt", "-out", "."], cwd=tmp_path, check=True,
                   stdout=subprocess.DEVNULL)
    theirs = np.asarray(nib.load(tmp_path / "result.nii.gz").dataobj)
    assert (theirs != expected).sum() <= 0.002 * (expected != 0).sum()


def test_warps_oracle_labels_of_a_file_are_those_of_its_array(tmp_path):
    """Truth: the same body from the array; places are rounded to float32 in the file."""
    scene = label_scene(two_labels())
    scene.save(tmp_path / "saved.toml")
    answers = [one.run("coupled", threads=1) for one in (scene, maille.load(tmp_path / "saved.toml"))]
    of_array, of_file = (answer.warped_labels() for answer in answers)
    assert [row["label"] for row in of_file] == [row["label"] for row in of_array] == [5, 17]
    for a, b in zip(of_array, of_file):
        assert b["sub_voxel_volume"] == pytest.approx(a["sub_voxel_volume"], rel=1e-5)


def test_sample_calf_analytic_its_files_are_of_one_leg(tmp_path):
    """Truth: the ellipse of the Achilles tendon at the ankle, and the names that the file states."""
    if "MAILLE_COMMAND" not in os.environ:
        pytest.skip("the command is not built")
    subprocess.run([os.environ["MAILLE_COMMAND"], "new", "calf"], cwd=tmp_path, check=True, capture_output=True)
    labels, scan = (nib.load(tmp_path / "calf" / name) for name in ("labels.nii.gz", "scan.nii.gz"))
    assert nib.aff2axcodes(labels.affine) == ("L", "P", "S") and np.array_equal(labels.affine, scan.affine)
    voxels = np.asarray(labels.dataobj)
    assert sorted(np.unique(voxels)) == list(range(11))
    voxel_area, girth = 4e-6, 0.62 + 0.38 * np.exp(-((2 / 240 - 0.68) / 0.36) ** 2)
    assert np.sum(voxels[..., 0] == 7) * voxel_area == pytest.approx(np.pi * 7e-3 * 4e-3 * girth**2, rel=0.25)
    for row, label in zip(np.loadtxt(tmp_path / "calf/landmarks.fcsv", delimiter=",", dtype=str), (3, 3, 7)):
        at = np.linalg.inv(labels.affine) @ [float(row[1]), float(row[2]), float(row[3]), 1]
        assert voxels[tuple(np.round(at[:3]).astype(int))] == label, row
    scene = maille.load(tmp_path / "calf/calf.toml")
    assert scene.run().labels[0]["volume"] == pytest.approx(np.sum(voxels == 3) * voxel_area * 4e-3, rel=0.02)
