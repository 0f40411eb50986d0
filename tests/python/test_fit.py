"""The fit of limits and weights, against families whose best numbers are known."""

import json
import math
import os
import subprocess

import numpy as np
import pytest

import maille

TISSUE = {"youngs_modulus": "10 kPa", "poisson_ratio": 0.3}
KNOWN = {"stretch": [1.3, 1.25, 1], "compress": [0.8, 0.7, 1], "shear": [[0, 0.22, 0], [0.18, 0, 0], [0, 0, 0]]}
OPEN = {"stretch": [2, 2, 2], "compress": [0, 0, 0], "shear": [[0, 1, 1], [1, 0, 1], [1, 1, 0]]}


def sheet(along, across, **constants):
    """A sheet that is held at its lower edge and has a spot in its middle moved."""
    return maille.Scene(maille.box((9, 7), 1e-3, {**TISSUE, **constants}), [maille.hold("y-")],
                        [maille.move({"box": [[0.004, 0.003], [0.005, 0.004]]}, by=(along, across))], units="m, rad",
                        limits={"from": "material"} if "stretch" in constants else None, name=f"sheet_{along}_{across}")


def of_two(along, across, near=None, far=None):
    """The same as one layer of cells, of another matter from the spot on."""
    labels = np.ones((9, 7, 1), dtype=np.uint8)
    labels[4:] = 2
    image = maille.Image(labels, affine=np.eye(4), labels={1: {**TISSUE, **(near or {})}, 2: {"youngs_modulus": "30 kPa", "poisson_ratio": 0.3, **(far or {})}})
    return maille.Scene(image, [maille.hold("y-")], [maille.move({"box": [[4e-3, 3e-3, 0], [5e-3, 4e-3, 1e-3]]}, by=(along, across, 0))], units="m, rad",
                        limits={"from": "material"} if near else None, name=f"two_{along}_{across}")


def numbers(found, material=None):
    return {one["name"]: one["value"] for one in found.numbers if material in (None, one["material"])}


def test_limits_oracle_that_made_the_data_come_back():
    """Every number decides some node, so all of them must come back."""
    moves = ((5e-4, 3e-4), (3e-4, 5e-4))
    found = maille.fit([sheet(*by) for by in moves], reference=[sheet(*by, **KNOWN).run("limits") for by in moves])
    assert found.status == "done" and found.relative_l2 < 1e-5
    wanted = {"stretch[x]": 1.3, "stretch[y]": 1.25, "compress[x]": 0.8, "compress[y]": 0.7, "shear[x][y]": 0.22, "shear[y][x]": 0.18}
    assert numbers(found) == pytest.approx(wanted, abs=1e-4)  # of slacks of 0.18 to 0.3; the search stops at 1e-8 of their logarithms
    assert all(one["determined"] for one in found.numbers)


def test_limits_oracle_of_two_materials_come_back():
    """And a scene that the fit has not seen is met as well."""
    near = {**KNOWN, "shear": [[0, 0.22, 1], [0.18, 0, 1], [1, 1, 0]]}
    far = {"stretch": [1.12, 1.1, 1], "compress": [0.91, 0.88, 1], "shear": [[0, 0.09, 1], [0.08, 0, 1], [1, 1, 0]]}
    moves = ((2.2e-4, 1.6e-4), (-1.6e-4, -2.2e-4), (2e-4, -1.8e-4))
    found = maille.fit([of_two(*by) for by in moves[:2]], [of_two(*moves[2])], reference=[of_two(*by, near, far).run("limits") for by in moves])
    assert found.status == "done" and [one["name"] for one in found.materials] == ["specimen.labels.1", "specimen.labels.2"]
    assert found.relative_l2 < 1e-4 and found.held_out[0]["relative_l2"] < 1e-3
    of_far = numbers(found, "specimen.labels.2")
    assert (of_far["stretch[y]"], of_far["shear[y][x]"]) == pytest.approx((1.1, 0.08), abs=2e-3)  # of slacks of 0.08 to 0.3


def test_weights_oracle_that_made_the_data_come_back():
    weights = {**OPEN, "relaxed_weights": [0.4, 2.5, 1]}
    one = maille.fit([sheet(5e-4, 3e-4)], method="relaxed", reference=[sheet(5e-4, 3e-4, **weights).run("relaxed")])
    assert one.relative_l2 < 1e-4  # relaxed itself ends at 1e-4
    assert list(numbers(one).values()) == pytest.approx([0.4, 2.5], rel=1e-2)
    moves, far = ((5e-4, 3e-4), (-3e-4, 5e-4)), {**OPEN, "relaxed_weights": [3, 0.6, 1]}
    two = maille.fit([of_two(*by) for by in moves], method="relaxed", reference=[of_two(*by, weights, far).run("relaxed") for by in moves])
    assert two.relative_l2 < 1e-4
    assert [one["relaxed_weights"][b] for one in two.materials for b in range(2)] == pytest.approx([0.4, 2.5, 3, 0.6], rel=2e-2)


def bar(pull):
    return maille.Scene(maille.box((8,), 1e-3, TISSUE), [maille.hold("x-")], [maille.move("x+", by=(pull,))], units="m, rad", name=f"bar_{pull}")


def test_a_bar_pulled_twice_analytic_is_taut_at_the_larger_pull():
    """A bar whose links all stretch alike, moved by A and by A/2. A link must give A/n, or the larger move is cut back; a larger
    limit leaves more nodes behind. In the smaller move the half next to the handle then follows, at full slack."""
    A, n = 8e-4, 8
    i = np.arange(n + 1)
    references = [pull * i[:, None] / n for pull in (A, A / 2)]
    expected = 0.0
    for pull, r in zip((A, A / 2), references):
        u = np.maximum(0, pull - A / n * (n - i))
        expected += np.sum((u - r[:, 0])[1:-1] ** 2) / np.sum(r[1:-1] ** 2) / 2
    found = maille.fit([bar(A), bar(A / 2)], reference=references)
    assert found.status == "done"
    assert numbers(found)["stretch[x]"] == pytest.approx(1 + A / n / 1e-3, abs=1e-6)
    assert not found.numbers[1]["determined"], "nothing is compressed"
    assert numbers(found)["compress[x]"] == 0, "open: it must not bind where another scene compresses"
    assert found.relative_l2 == pytest.approx(math.sqrt(expected), abs=1e-4)
    assert found.fitted[0]["status"] == "done" and found.fitted[1]["alone"] < 1e-5, "alone, it is the taut bar"


def test_what_nothing_moves_analytic_is_out_of_reach():
    """A strip that narrows as it is pulled. What it narrows by is what limits cannot do."""
    scene = maille.Scene(maille.box((4, 2), 1e-3, TISSUE), [maille.hold("x-", "x")], [maille.move("x+", by=(4e-4, 0), axes="x")], units="m, rad")
    y, x = np.mgrid[0:3, 0:5]
    reference = np.stack([1e-4 * x, -3e-5 * (y - 1)], axis=-1)
    free = reference[:, 1:4]
    found = maille.fit([scene], reference=[reference])
    lost = found.fitted[0]["at_least_by_component"]
    assert lost[0] == 0 and lost[1] == pytest.approx(math.sqrt(np.sum(free[..., 1] ** 2) / np.sum(free**2)), abs=1e-12)
    assert found.fitted[0]["relative_l2"] == pytest.approx(lost[1], abs=1e-5), "and what is in reach is reached"


def test_fits_contract_repeat_to_the_bit_and_end_with_the_best_so_far(tmp_path):
    reference = [sheet(5e-4, 3e-4, **KNOWN).run("limits")]
    first, second = (maille.fit([sheet(5e-4, 3e-4)], reference=reference) for _ in range(2))
    assert first.materials == second.materials
    calls = []

    def stop(part, what):
        calls.append(part)
        if len(calls) > 300:
            raise KeyboardInterrupt

    one = maille.fit([sheet(5e-4, 3e-4)], reference=reference, progress=stop)
    assert one.status == "interrupted" and one.fitted[0]["status"] == "done"
    assert maille.fit([sheet(5e-4, 3e-4)], reference=reference, trials=20).status == "budget_reached"
    first.save(tmp_path / "found.toml")
    again = maille.Scene.from_dict({**sheet(5e-4, 3e-4).document(), "limits": {"from": "material"}}, folder=tmp_path)
    again = again.with_values({"specimen.material": "found.toml"}).run("limits")
    assert maille.compare(again, reference=reference[0]).relative_l2 == pytest.approx(first.relative_l2, abs=1e-12)


def test_commands_contract_find_what_notebooks_find(tmp_path):
    import maille.fem

    if not maille.fem.is_available():
        pytest.skip("finite elements were not built")
    for name, by in (("pulled", (0.6e-3, 0, 0)), ("bent", (0, 0, 0.5e-3))):
        maille.Scene(maille.box((6, 3, 3), 1e-3, TISSUE), [maille.hold("x-")], [maille.move("x+", by=by)], units="m, rad").save(tmp_path / f"{name}.toml")
    files = [tmp_path / "pulled.toml", tmp_path / "bent.toml"]
    run = subprocess.run([os.environ["MAILLE_COMMAND"], "fit", *map(str, files), "--json"], capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    found, wanted = maille.fit([maille.load(file) for file in files]), json.loads(run.stdout)
    assert [one["name"] for one in found.numbers] == [one["name"] for one in wanted["numbers"]] and ["maille", *found.record()] == list(wanted)
    # To the rounding of references: the command's second one goes on with the factor of the first.
    assert found.relative_l2 == pytest.approx(wanted["fitted"]["relative_l2"], rel=1e-6)
    assert "root mean square" in str(found)


def test_scenes_contract_that_move_nothing_are_refused():
    with pytest.raises(ValueError, match="nodes are free and move"):
        maille.fit([bar(0)], reference=[np.zeros((9, 1))])
    with pytest.raises(ValueError, match="nothing to fit limits to"):
        maille.fit([bar(0)], reference=[np.ones((9, 1))])
    with pytest.raises(ValueError, match="limits carry no loads"):
        loaded = {**bar(1e-4).document(), "load": [maille.load_on(gravity=(-9.81,))]}
        maille.fit([maille.Scene.from_dict(loaded)], reference=[np.ones((9, 1))])
