"""Scenes from arrays, files and mappings, and what is wrong with them."""

import copy
import pickle

import numpy as np
import pytest

import maille
from conftest import AFFINE, STRIP, ended, faults_of_four_threads, label_scene, two_labels


def test_arrays_oracle_any_strides_types_and_byte_orders_are_the_same_scene():
    """Truth: the same labels in C order of uint8."""
    plain = label_scene(two_labels()).run("coupled", threads=1).displacement
    assert np.abs(plain).max() > 1e-4
    base = two_labels()
    stored = np.zeros((16, 14, 18), dtype=">i4")
    stored[::2, ::2, 17::-3] = base
    others = [base.astype(t) for t in ("u1", "i1", ">u2", "<i2", ">i4", "i8", ">u4", "u8", "f4", ">f8")]
    others += [np.asfortranarray(base), base[::-1][::-1], stored[::2, ::2, 17::-3], base[..., np.newaxis]]
    for labels in others:
        u = label_scene(labels).run("coupled", threads=1).displacement
        assert np.array_equal(u, plain), labels.dtype


def test_arrays_contract_what_is_no_array_of_labels_is_one_clear_type_error():
    for wrong in (np.ones((3, 3, 3)) / 2, np.ones(3), np.ones((2, 2, 2, 2)), np.ones((3, 3, 3), dtype=complex),
                  np.array([["a"]])):
        with pytest.raises(TypeError, match="expected labels"):
            label_scene(wrong).check()


def test_scenes_contract_every_fault_is_told_at_once(tmp_path):
    labels = two_labels()
    scene = maille.Scene(maille.Image(labels, affine=AFFINE, labels={17: "muscle/solus", 5: "muscle/soleus"}),
                         holds=[maille.hold("q-")], moves=[maille.move("z+", by=(0, "7.5 kPa", 0))])
    with pytest.raises(maille.SceneFaults) as raised:
        scene.check()
    keys = {fault.key for fault in raised.value.faults}
    assert {"specimen.labels.17", "hold[1].where", "move[1].by"} <= keys
    assert all(fault.expected and fault.found for fault in raised.value.faults)
    file = tmp_path / "bad.toml"
    file.write_text(STRIP.replace("[8, 4, 4]", "[0]").replace('"x+"', '"w+"'))
    with pytest.raises(maille.SceneFaults) as raised:
        maille.load(file)
    assert [fault.line for fault in raised.value.faults] == [4, 10]
    assert raised.value.faults[0].file == str(file)
    assert isinstance(raised.value, ValueError)


def test_scenes_oracle_a_mapping_is_the_file(strip):
    """Truth: the file's own answer."""
    by_file = maille.load(strip).run("relaxed", threads=1)
    scene = maille.Scene(maille.box((8, 4, 4), "1 mm", {"youngs_modulus": "10 kPa", "poisson_ratio": 0.3}),
                         holds=[maille.hold("x-")], moves=[maille.move("x+", by=("0.4 mm", 0, 0))])
    assert np.array_equal(scene.run("relaxed", threads=1).displacement, by_file.displacement)
    again = maille.Scene.from_dict(maille.load(strip).document())
    assert np.array_equal(again.run("relaxed", threads=1).displacement, by_file.displacement)


def test_scenes_oracle_what_is_saved_is_the_scene(tmp_path, strip):
    """Truth: the scene's own answer before it was saved; places are rounded to float32 in NIfTI."""
    for scene in (label_scene(two_labels(), title="two labels"), maille.load(strip)):
        scene.save(tmp_path / "elsewhere.toml")
        same = maille.load(tmp_path / "elsewhere.toml")
        assert same.cells == scene.cells
        u, v = scene.run("coupled").displacement, same.run("coupled").displacement
        assert np.abs(u - v).max() < 1e-6 * np.abs(u).max()
    below = tmp_path / "below"
    below.mkdir()
    maille.load(tmp_path / "elsewhere.toml").save(below / "moved.toml")
    assert maille.load(below / "moved.toml").cells == same.cells


def test_scenes_contract_sizes_and_warnings(strip):
    scene = maille.load(strip)
    report = scene.check()
    assert report.size == pytest.approx((8e-3, 4e-3, 4e-3))
    assert report.largest_move == pytest.approx(4e-4)
    assert report.mean_strain == pytest.approx(0.05)
    assert report.cells == 128 and report.nodes == 9 * 5 * 5
    assert scene.dimension == 3 and scene.cells == (8, 4, 4) and scene.nodes == (9, 5, 5)
    assert scene.material_id.shape == (4, 4, 8) and scene.labels is None
    labelled = label_scene(two_labels())
    assert labelled.labels.shape == labelled.material_id.shape == (4, 5, 6)
    assert set(labelled.labels.ravel()) == {5, 17} and labelled.labels[0, 0, 0] == 17
    # Node 0 is the outer corner of voxel (1, 1, 1).
    assert labelled.node_affine[:3, 3] * 1e3 == pytest.approx((AFFINE @ [0.5, 0.5, 0.5, 1])[:3])


def test_scenes_contract_moves_that_turn_and_regions_are_those_of_files():
    scene = maille.Scene(maille.Image(two_labels(), affine=AFFINE, material="muscle/soleus", fibre=(1, 0, 0)),
                         holds=[maille.hold({"box": [[0, 0, 0], ["1 m", "1 m", "4 mm"]]})],
                         moves=[maille.move("z+", turn={"angle": "3 deg", "axis": [0, 0, 1]})])
    u = scene.run("coupled").displacement
    assert np.abs(u[-1, 0, 0, :2]).max() > 1e-5 and np.abs(u[0]).max() == 0


def test_scenes_contract_the_world_of_an_affine_is_the_patients():
    """Right, anterior, superior, as nibabel has it; without an affine nothing is known of the patient."""
    labels = np.zeros((8, 7, 14), dtype=np.uint8)
    labels[2:5, 2:5, 1:13] = 17                                               # long along k
    ends = dict(holds=[maille.hold({"label": 17, "end": "distal", "depth": "4 mm"})],
                moves=[maille.move({"label": 17, "end": "proximal", "depth": "4 mm"}, by=(0, 0, "0.1 mm"))])
    scene = maille.Scene(maille.Image(labels, affine=AFFINE, labels={17: "muscle/soleus"}, fibre=(1, 0, 0)), **ends)
    u = scene.run("limits").displacement
    assert np.abs(u[0]).max() == 0 and u[-1, 0, 0, 2] == pytest.approx(1e-4)  # superior is up the k axis
    turned = AFFINE.copy()
    turned[:3, 2] *= -1
    u = maille.Scene(maille.Image(labels, affine=turned, labels={17: "muscle/soleus"}, fibre=(1, 0, 0)), **ends).run("limits").displacement
    assert np.abs(u[-1]).max() == 0 and np.abs(u[0]).max() > 5e-5
    with pytest.raises(maille.SceneFaults, match="patient"):
        maille.Scene(maille.Image(labels, labels={17: "muscle/soleus"}, fibre=(1, 0, 0)), **ends).check()


def test_values_contract_are_put_at_keys_of_files(strip):
    scene = maille.load(strip)
    forces = [scene.with_values({"specimen.material.youngs_modulus": value}).run().moves[0]["force"][0] for value in ("10 kPa", "20 kPa")]
    assert forces[1] == pytest.approx(2 * forces[0], rel=1e-3)
    assert scene.document()["move"][0]["by"][0] == "0.4 mm"
    for key in ("move[2].by", "move[0].by", "move.1.by", "move[1].by[4]", "move.by"):
        with pytest.raises(ValueError, match="expected a key"):
            scene.with_values({key: [0, 0, 0]})
    for key in ("move[1].by[1]", "move.0.by.0"):  # counted from 1, and the older form
        assert scene.with_values({key: "0.2 mm"}).document()["move"][0]["by"] == ["0.2 mm", 0, 0]


def test_units_contract_a_bare_length_is_refused_unless_units_are_given(tmp_path):
    plain, solid = np.ones((3, 3, 3), dtype=np.uint8), {"youngs_modulus": "10 kPa", "poisson_ratio": 0.3}
    with pytest.raises(maille.SceneFaults, match="specimen.spacing: expected a length"):
        maille.Scene(maille.box((3, 3, 3), 1, solid), holds=[maille.hold("x-")]).check()
    with pytest.raises(ValueError, match="spacing: expected a length"):
        maille.Scene(maille.Image(plain, material=solid, spacing=1), holds=[maille.hold("x-")]).check()
    two = np.diag([2.0, 2, 2, 1])
    for spacing in ("2 mm", 2, (2, "2 mm", 2.0)):
        assert maille.Image(plain, affine=two, spacing=spacing).rows() == maille.Image(plain, affine=two).rows()
    for spacing in ("1 mm", 2e-3, (2, 2, 1)):
        with pytest.raises(ValueError, match="spacing: expected that of the affine, 2, 2, 2 mm, or none"):
            maille.Image(plain, affine=two, spacing=spacing).rows()
    for body in (maille.box((3, 3, 3), 1, solid), maille.Image(plain, material=solid, spacing=1, unit="mm"),
                 maille.Image(plain, material=solid, spacing="1 mm")):
        for units, by in ((None, 2), ("mm", 2)):
            scene = maille.Scene(body, holds=[maille.hold("x-")], moves=[maille.move("x+", by=(by, 0, 0))], units=units)
            if units is None:
                with pytest.raises(maille.SceneFaults, match="expected a length"):
                    scene.check()
            else:
                assert scene.check().largest_move == pytest.approx(2e-3) and scene.spacing == pytest.approx((1e-3,) * 3)
    for read in (maille.load, maille.World):
        with pytest.raises(FileNotFoundError):
            read(tmp_path / "none.toml")


def test_comparisons_contract_rows_and_errors(strip):
    compared = maille.load(strip).compare(("limits", "coupled"))
    assert [row["method"] for row in compared.rows] == ["limits", "coupled"]
    assert compared.rows[0]["relative_l2"] > 0.01 and "relative_l2" not in compared.rows[1]
    errors = maille.compare(compared.answers["coupled"], reference=compared.answers["coupled"])
    assert errors.relative_l2 == 0 and errors.force == 0


def test_scenes_oracle_frames_and_sliding_borders_are_those_of_files(tmp_path):
    """Truth: the file's own answer. In RAS the move is along the affine's axes, not the array's."""
    scene = maille.Scene(
        maille.Image(two_labels(), affine=AFFINE, labels={17: "muscle/soleus", 5: "muscle/soleus"}, fibre=(1, 0, 0)),
        holds=[maille.hold("x-")], moves=[maille.move("x+", by=("0.1 mm", "0.2 mm", 0), frame="ras")],
        sliding=[{"between": [5, 17]}])
    file = tmp_path / "glides.toml"
    file.write_text("another's")
    with pytest.raises(FileExistsError, match="overwrite=True"):
        scene.save(file)
    scene.save(file, overwrite=True)
    scene.save(file)
    text = file.read_text()
    assert 'frame = "ras"' in text and "[[sliding]]" in text
    by_array = scene.run("coupled", threads=1).displacement
    assert np.allclose(maille.load(file).run("coupled", threads=1).displacement, by_array, atol=1e-9)
    prescribed = by_array[:, :, -1].reshape(-1, 3)
    assert np.allclose(prescribed, [1e-4, 2e-4, 0])


def test_scenes_contract_what_drives_a_bone_is_that_of_files():
    scene = maille.Scene(
        maille.Image(two_labels(), affine=AFFINE, labels={17: "muscle/soleus", 5: "bone/cortical_tibia"}, fibre=(1, 0, 0)),
        holds=[maille.hold("z-")], drives=[{"label": 5, "by": ["0.1 mm", 0, 0]}])
    u = scene.run("coupled", threads=1, frame="grid").displacement
    assert np.allclose(u[-1, ..., 0], 1e-4)


def test_imports_contract_a_numpy_that_the_module_does_not_know_is_said(tmp_path):
    if maille._core.knows_numpy_2:
        pytest.skip("built with a pybind11 that knows numpy 2")
    program = "import numpy; numpy.__version__ = '2.1.0'; import maille"
    run = ended(program)
    assert run.returncode != 0 and "numpy 2.1.0 is installed" in run.stderr


def test_scenes_contract_faults_of_what_is_in_memory_name_no_file():
    with pytest.raises(maille.SceneFaults) as raised:
        maille.Scene(maille.box((8, 4), "1 mm", "muscle/solus"), holds=[maille.hold("q-")]).check()
    assert len(raised.value.faults) == 2
    assert all(fault.file == "" and fault.line == 0 for fault in raised.value.faults)
    assert "scene.toml" not in str(raised.value) and "hold[1].where: expected" in str(raised.value)


def test_scenes_oracle_copies_and_pickles_are_the_scene():
    """Truth: the scene's own answer."""
    scene = label_scene(two_labels())
    u = scene.run("coupled", threads=1).displacement
    for other in (copy.deepcopy(scene), copy.copy(scene), pickle.loads(pickle.dumps(scene))):
        assert np.array_equal(other.run("coupled", threads=1).displacement, u)


def test_drags_contract_one_thread_at_a_time():
    drag = label_scene(two_labels()).drag()
    nodes = drag._scene.nodes_in("z+")

    def pull(thread, time):
        drag.move(nodes, by=(0.0, 0.0, 1e-5 * (thread + 1) * time))
        drag.displacement
        drag.residue

    assert all("one thread at a time" in text for text in faults_of_four_threads(pull, 60))
    assert np.isfinite(drag.displacement).all()


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf")])
def test_numbers_contract_nan_and_infinity_are_refused(bad):
    scene = label_scene(two_labels())
    drag = scene.drag()
    for axis in range(3):
        by = [0.0, 0.0, 0.0]
        by[axis] = bad
        with pytest.raises(ValueError):
            drag.move("z+", by=tuple(by))
    assert np.isfinite(drag.displacement).all()
    for wrong in ({"tolerance": bad}, {"seconds": bad if bad != float("inf") else -1.0}):
        with pytest.raises(ValueError):
            scene.run("coupled", threads=1, **wrong)


def test_arrays_contract_masked_voxels_are_refused():
    masked = np.ma.masked_equal(two_labels(), 17)
    with pytest.raises(TypeError, match="mask"):
        label_scene(masked).check()
