"""Worlds, frame by frame."""

import numpy as np
import pytest

import maille
from conftest import faults_of_four_threads

WORLD = """
[world]
cells = [20, 20, 20]
spacing = "1 mm"
[[object]]
name = "floor"
kind = "fixed"
shape = "box"
cells = [20, 20, 4]
[[object]]
name = "pad"
kind = "deformable"
shape = "box"
cells = [6, 6, 6]
spacing = "1 mm"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
hold = [{ where = "z-" }]
limits = { from = "given", stretch = 2, compress = 0.1, shear = 1 }
position = ["10 mm", "7 mm", "5 mm"]
[[object]]
name = "finger"
kind = "rigid"
shape = "box"
cells = [2, 2, 2]
position = ["12 mm", "9 mm", "12 mm"]
"""


@pytest.fixture
def world(tmp_path):
    file = tmp_path / "pressed.toml"
    file.write_text(WORLD)
    return maille.World(file)


def test_worlds_contract_a_finger_presses_a_pad(world):
    assert world.objects == {"floor": "fixed", "pad": "deformable", "finger": "rigid"}
    z = world.pose("finger")[2, 3]
    for _ in range(3):
        frame = world.advance([maille.drive("finger", by=(0, 0, "-1 mm"))])
        assert frame.status in ("done", "clamped")
    assert frame.number == 3
    assert world.pose("finger")[2, 3] < z - 1e-3
    u = world.displacement("pad")
    assert u.shape == (7, 7, 7, 3) and u[..., 2].min() < -1e-4 and not u[0].any()
    assert any(contact["object"] == "pad" or contact["other"] == "pad" for contact in frame.contacts)
    with pytest.raises(KeyError):
        world.displacement("nobody")
    with pytest.raises(ValueError, match="deformable"):
        world.displacement("floor")


def test_worlds_oracle_recorded_input_is_the_same_as_by_hand(tmp_path, world):
    """Truth: the same drives by hand."""
    file = tmp_path / "down.toml"
    file.write_text('frame_time = "100 ms"\n[[drive]]\nobject = "finger"\nby = [0, 0, "-2 mm"]\nframes = 3\n')
    other = maille.World(tmp_path / "pressed.toml")
    frames = 0
    for frame in world.play(file, threads=1):
        frames += 1
        assert frame.number == frames
        other.advance([maille.drive("finger", by=(0, 0, -2e-3 / 3))], threads=1)
        assert np.array_equal(world.displacement("pad"), other.displacement("pad"))
        assert world.pose("finger") == pytest.approx(other.pose("finger"))
    assert frames == 3


def test_worlds_contract_faults_are_those_of_files(tmp_path, world):
    (tmp_path / "bad.toml").write_text(WORLD.replace("[20, 20, 20]", "[0, 1]").replace('"rigid"', '"rugid"'))
    with pytest.raises(maille.SceneFaults) as raised:
        maille.World(tmp_path / "bad.toml")
    assert len(raised.value.faults) >= 2
    (tmp_path / "bad_path.toml").write_text('[[drive]]\nobject = "fingr"\n')
    with pytest.raises(maille.SceneFaults):
        world.play(tmp_path / "bad_path.toml")


def test_worlds_contract_one_thread_at_a_time(world):
    """A second thread is refused or waits for its turn at the interpreter's lock; neither ends the process."""

    def play(_, n):
        world.advance([maille.drive("finger", by=(0, 0, "-0.5 mm" if n % 8 < 4 else "0.5 mm"))], threads=1)
        world.pose("finger")

    errors = faults_of_four_threads(play, 200, until_first=True)
    assert errors and all("one thread at a time" in text for text in errors)
    assert np.isfinite(world.displacement("pad")).all()


@pytest.mark.parametrize("bad", [float("nan"), float("inf"), -float("inf")])
def test_worlds_contract_numbers_that_are_not_finite_are_refused_and_frames_have_a_bound(world, bad):
    for what in ({"by": (bad, 0, 0)}, {"axis": (0, 0, bad)}, {"angle": bad}, {"about": (0, bad, 0), "angle": 0.1}):
        with pytest.raises(ValueError):
            world.advance([maille.drive("finger", **what)], threads=1)
    frame = world.advance([maille.drive("finger", by=(0, 0, "-1e9 mm"))], threads=1)
    assert frame.status == "clamped" and frame.rounds <= 3000
    with pytest.raises(ValueError):
        world.advance([maille.drive("finger", about=(1e300, 0, 0), angle=0.1)], threads=1)


def test_worlds_contract_a_trajectory_of_another_world_is_refused(world, tmp_path):
    (tmp_path / "other.toml").write_text(WORLD)
    (tmp_path / "press.toml").write_text(
        'frames = 1\nframe_time = "10 ms"\n[[drive]]\nobject = "finger"\nby = [0, 0, "-1 mm"]\n')
    from maille import _core

    other = maille.World(tmp_path / "other.toml")
    trajectory = _core.Trajectory(str(tmp_path / "press.toml"), other._core)
    with pytest.raises(ValueError, match="this world"):
        world._core.play(trajectory, 1, 1)
