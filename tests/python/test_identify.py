"""Constants from measured numbers: the search by itself on models in closed form, ``maille.identify``, and the command."""

import json
import math
import os
import random
import subprocess

import numpy as np
import pytest
from conftest import press_ctrl_c

import maille
from maille._identify import Observation, Search, constants_in, read_observations

BLOCK = """units = "mm"
[specimen]
shape = "box"
cells = [8, 4, 4]
spacing = 1
material = { E_fibre = "30 kPa", E_cross = "12 kPa", G_fibre = "5 kPa", nu_fibre = 0.3, nu_cross = 0.4 }
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = [0.4, 0, 0.4]
[[measure]]
name = "pull"
force = "move[1]"
[[measure]]
name = "side"
displacement = { at = [4, 4, 2] }
component = "y"
"""
E, G = "specimen.material.E_fibre", "specimen.material.G_fibre"


def observed(values, sigma=None):
    return [Observation("y", value, sigma) for value in values]


def found(unknowns, observations, model, *settings):
    return Search(unknowns, observations, model, *settings).run()


def decay(n):
    """y_i = a exp(-b i), i = 0 ... n - 1."""
    return lambda p: p[0] * np.exp(-p[1] * np.arange(n))


def command(*words):
    return subprocess.run([os.environ["MAILLE_COMMAND"], "fit", *map(str, words)], capture_output=True, text=True)


def test_exact_data_analytic_give_what_they_were_made_with():
    for start in (0.01, 0.3, 1.0, 40.0):
        one = found([("E", start * 12e3)], observed([0.02 * 12e3]), lambda p: [0.02 * p[0]])
        assert one.status == "done", one.message
        assert one.unknowns[0].value == pytest.approx(12e3, rel=1e-3)
        assert one.solves <= 36  # 12 a start
        assert one.unknowns[0].interval is None, "one datum and no sigma tell nothing of its error"
    # A pull towards -x, far from a line in its stiffness.
    negative = found([("E", 12)], observed([-(500**0.1)], 0.001), lambda p: [-(p[0] ** 0.1)])
    assert negative.status == "done" and negative.unknowns[0].value == pytest.approx(500, abs=0.5)
    data = decay(6)([3, 0.4])
    two = found([("a", 1), ("b", 1.5)], observed(data), decay(6))
    assert two.status == "done" and two.solves <= 72
    assert [one.value for one in two.unknowns] == pytest.approx([3, 0.4], rel=1e-3)
    assert two.computed == pytest.approx(list(data), rel=1e-3)


@pytest.mark.parametrize("is_known", [True, False])
def test_intervals_analytic_hold_the_truth_as_often_as_they_say(is_known):
    """95 times of 100, in 600 draws to 3 standard deviations."""
    noise = np.random.default_rng(7)
    exact, sigma, draws, truth = decay(7)([3, 0.4]), 0.02, 600, (3, 0.4)
    held = [0, 0]
    for _ in range(draws):
        data = exact + sigma * (1 if is_known else exact) * noise.standard_normal(7)
        one = found([("a", 2), ("b", 0.5)], observed(data, sigma if is_known else None), decay(7))
        assert one.status == "done", one.message
        for j in range(2):
            low, high = one.unknowns[j].interval
            held[j] += low <= truth[j] <= high
    assert all(0.923 * draws < count < 0.977 * draws for count in held), held


def test_what_data_leave_open_analytic_is_named():
    """By construction: a product tells nothing of its factors, and what is not in a model nothing at all."""
    together = found([("width", 2), ("height", 7)], observed([6, 12, 30], 0.01), lambda p: p[0] * p[1] * np.array([1, 2, 5]))
    assert together.status == "undetermined" and "width and height one by one" in together.message
    assert not any(one.is_determined for one in together.unknowns)
    assert together["width"].value * together["height"].value == pytest.approx(6, abs=1e-3)
    unheard = found([("E", 2), ("nu", 0.3)], observed([4, 12], 0.01), lambda p: [p[0], 3 * p[0] * p[1] ** 1e-7])
    assert unheard.status == "undetermined" and "determine nu: a change of it" in unheard.message
    assert unheard["E"].is_determined and unheard["E"].value == pytest.approx(4, abs=1e-3)


def test_what_fits_as_well_elsewhere_analytic_is_named():
    """By construction: x and 1 / x fit alike, and a plateau hides an unknown that slopes at its rim still tell."""
    both = found([("E", 2), ("G", 5)], observed([0.25, 0.75, 8], 0.01), lambda p: [math.log(p[0]) ** 2, 3 * math.log(p[0]) ** 2, 2 * p[1]])
    assert both.status == "undetermined" and "E: " in both.message
    assert not both["E"].is_determined and both["G"].is_determined
    hidden = found([("E", 1), ("E_cross", 3)], observed([1, 0.97], 0.02), lambda p: [p[0], p[0] / (1 + p[1] ** -2)])
    assert hidden.status == "undetermined" and not hidden["E_cross"].is_determined


def test_searches_contract_end_where_the_model_does():
    failed = found([("E", 1)], observed([1, 2]), lambda p: None)
    assert failed.status == "failed" and not failed.unknowns[0].is_determined
    calls = []

    def interrupted(p):
        calls.append(p)
        if len(calls) > 4:
            raise KeyboardInterrupt
        return decay(3)(p)

    assert found([("a", 1), ("b", 1)], observed([1, 2, 3]), interrupted).status == "interrupted"
    assert found([("a", 1), ("b", 9)], observed(decay(5)([300, 0.1])), decay(5), 1e-4, 4).status == "budget_reached"


UNITS = {"pull": "N", "tip": "m", "work": "J"}


def test_observations_contract_say_every_fault_at_once():
    good = read_observations("# a comment\nmeasure, value, sigma\npull, 20 N, 0.5 N\ntip, 2 mm, 0.1 mm\nwork,3,1\n", "data.csv", UNITS)
    assert [(one.value, one.line) for one in good] == [(20, 3), (2e-3, 4), (3, 5)] and good[1].sigma == 1e-4
    with pytest.raises(maille.SceneFaults) as bad:
        read_observations("measure,value,sigma\npul,1,1\npull,2 mm,1\ntip,1,-3\ntip,1\nwork,nan,1\na,b,c,d\n", "data.csv", UNITS)
    assert [fault.line for fault in bad.value.faults] == [2, 3, 4, 5, 6, 7, 5], bad.value
    for text in ("", "value,measure\n", "measure,value\n", "measure\npull\n"):
        with pytest.raises(maille.SceneFaults) as bad:
            read_observations(text, "data.csv", UNITS)
        assert len(bad.value.faults) == 1


def test_observations_contract_of_any_text_are_numbers_or_faults():
    """2,000 mutations of a good table, with a fixed seed."""
    lot = random.Random(3)
    good = "measure,value,sigma\npull,20 N,0.5 N\ntip,2 mm,0.1 mm\n\"work\",3,1\n"
    pieces = ["\0", '"', ",", "\n", "\r", "#", "-", "1e999", "nan", "\ufeff", "\ufffd", "0", "mm", "tip", " " * 9]
    read = 0
    for _ in range(2000):
        text = good
        for _ in range(lot.randint(1, 4)):
            at = lot.randrange(len(text) + 1)
            text = text[:at] + lot.choice(pieces) + text[at + lot.randint(0, 3):]
        try:
            for one in read_observations(text, "a.csv", UNITS):
                assert math.isfinite(one.value) and (one.sigma is None or one.sigma > 0)
            read += 1
        except maille.SceneFaults as faulty:
            assert faulty.faults
    assert 0 < read < 2000


def test_constants_contract_go_by_keys_and_by_materials():
    assert constants_in(["E_fibre", " E_cross of muscle/soleus", "move[1].by"]) == [
        ("E_fibre", "muscle/soleus"), ("E_cross", "muscle/soleus"), ("move[1].by", "")]
    assert constants_in(["a.b", "E of x", "F of y"]) == [("a.b", ""), ("E", "x"), ("F", "y")]


def observations_of(scene, names=("pull_x", "pull_z", "side")):
    """The measures of an answer as a table."""
    measures = scene.run("coupled", tolerance=1e-7).measures
    x, _, z = measures["pull"]
    values = {"pull_x": f"{x!r} N", "pull_z": repr(z), "side": repr(measures["side"])}
    return "measure,value\n" + "".join(f"{name},{values[name]}\n" for name in names)


@pytest.fixture
def truth(tmp_path):
    (tmp_path / "truth.toml").write_text(BLOCK)
    return maille.load(tmp_path / "truth.toml")


def test_commands_analytic_find_the_constants_of_their_own_answer(truth, tmp_path):
    (tmp_path / "data.csv").write_text(observations_of(truth))
    start = tmp_path / "start.toml"
    start.write_text(BLOCK.replace("30 kPa", "90 kPa").replace('"5 kPa', '"2 kPa'))
    (tmp_path / "out").mkdir()
    fitted = tmp_path / "out/fitted.toml"
    run = command(start, "--measured", tmp_path / "data.csv", "--unknown", f"{E},{G}", "--json", "--out", fitted)
    assert run.returncode == 0, run.stderr
    answer = json.loads(run.stdout)
    assert answer["status"] == "done" and answer["solves"] <= 72
    assert [one["value"] for one in answer["unknowns"]] == pytest.approx([30, 5], rel=1e-2)
    for row in answer["observations"]:
        assert row["computed"] == pytest.approx(row["measured"], rel=1e-3)
    assert fitted.read_text().startswith("# Made by maille fit ")
    run = command(start, "--measured", tmp_path / "data.csv", "--unknown", f"{E},{G}", "--out", fitted)
    assert run.returncode == 0, run.stderr
    # The written scene says what was computed.
    again = maille.load(fitted).run("coupled", tolerance=1e-7).measures
    assert again["pull"][0] == pytest.approx(answer["observations"][0]["computed"], rel=1e-6)


def test_commands_analytic_find_constants_by_the_name_of_their_material(tmp_path):
    old = '{ E_fibre = "30 kPa", E_cross = "12 kPa", G_fibre = "5 kPa", nu_fibre = 0.3, nu_cross = 0.4 }'
    soleus = '{ E_fibre = "13 kPa", E_cross = "3.68 kPa", G_fibre = "2 kPa", nu_fibre = 0.4566, nu_cross = 0.7113 }'
    (tmp_path / "truth.toml").write_text(BLOCK.replace(old, soleus))
    data = tmp_path / "data.csv"
    data.write_text(observations_of(maille.load(tmp_path / "truth.toml"), ("pull_x", "pull_z")))
    scene = tmp_path / "start.toml"
    scene.write_text(BLOCK.replace(old, '"muscle/soleus"'))
    run = command(scene, "--measured", data, "--unknown", "E_fibre, G_fibre of muscle/soleus", "--json", "--out", tmp_path / "fitted.toml")
    unknowns = json.loads(run.stdout)["unknowns"]
    assert unknowns[0]["unknown"] == "E_fibre of muscle/soleus"
    assert [one["value"] for one in unknowns] == pytest.approx([13e3, 2e3], rel=1e-2)
    maille.load(tmp_path / "fitted.toml").check()
    for unknown, words in (("E_fibre of muscle/masseter", "the name of a material in [specimen]"),
                           ("youngs_modulus of muscle/soleus", "one of E_fibre, E_cross, G_fibre"),
                           ("stiffness of muscle/soleus", "a constant that stands in its table")):
        run = command(scene, "--measured", data, "--unknown", unknown)
        assert run.returncode == 2 and words in run.stderr


def test_commands_contract_say_what_is_wrong_and_what_is_open(truth, tmp_path):
    def file(name, text):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    scene = tmp_path / "truth.toml"
    data = file("data.csv", "measure,value,sigma\npull_x,0.02,0.001\nside,-0.05 mm,0.01 mm\n")
    for measured, words, wanted in (
            (data, ["specimen.material.E"], "--unknown: expected keys of the scene"),
            (data, ["specimen.shape"], "expected a number > 0"),
            (data, [E, "--method", "limits"], "knows forces"),
            (data, [E, "--sigma", "1 mm"], "--sigma: expected an image"),
            (data, [f"{E},specimen.material.E_cross,{G}"], "at least as many"),
            (file("odd.csv", "measure,value\npush,1\n"), [E], "odd.csv:2: measure: expected a measure of the scene: pull, pull_x"),
            (tmp_path / "nowhere.csv", [E], "nowhere.csv"),
            (data, [E, "--out", data], "--out"),
            (file("tiny.csv", "measure,value,sigma\npull_x,0.02,1e-300\n"), [E], "--measured: expected a sigma of 4.4e-18 or more"),
            (file("zero.csv", "measure,value\npull_x,0\n"), [E], "zeros alone")):
        run = command(scene, "--measured", measured, "--unknown", *words)
        assert run.returncode == 2 and wanted in run.stderr and "warning" not in run.stderr, (words, run)
    anothers = file("anothers.toml", "title = 'mine'\n")
    run = command(scene, "--measured", data, "--unknown", E, "--out", anothers)
    assert run.returncode == 2 and "that Maille wrote" in run.stderr and anothers.read_text() == "title = 'mine'\n", run
    # Stiffness alone changes no displacement where all that is done to a body is to move it.
    isotropic = BLOCK[:BLOCK.index("material =")] + 'material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }\n' + BLOCK[BLOCK.index("[[hold]]"):]
    side = file("side.csv", "measure,value,sigma\nside,-0.05 mm,0.01 mm\n")
    run = command(file("iso.toml", isotropic), "--measured", side, "--unknown", "specimen.material.youngs_modulus")
    assert run.returncode == 1 and "do not determine specimen.material.youngs_modulus" in run.stdout, run


def test_several_scenes_analytic_give_what_none_gives_alone(truth):
    """A pull tells E alone, a shear G alone."""
    start = truth.with_values({E: "90 kPa", G: "2 kPa"})
    steps = [{"move[1].by": by} for by in ([0.4, 0, 0], [0, 0, 0.4])]
    data = [{name: truth.with_values(step).run("coupled", tolerance=1e-7).measures["pull"][axis]}
            for step, name, axis in zip(steps, ("pull_x", "pull_z"), (0, 2))]
    both = maille.identify([start.with_values(step) for step in steps], data, [E, G])
    assert both.status == "done", both.message
    assert [one.value for one in both.unknowns] == pytest.approx([30, 5], rel=1e-2)
    assert len(both.scenes) == 2 and both.scenes[0].run().measures["pull"][0] == pytest.approx(data[0]["pull_x"], rel=1e-3)


def test_force_curves_analytic_give_the_stiffness_of_a_bar_with_limits(truth, tmp_path):
    """Limits stiffen the bar from some step on, so the curve is no line."""
    limits = {"from": "given", "stretch": 1.03, "compress": 0.5, "shear": 1.0}
    stiff = maille.Scene.from_dict({**truth.document(), "limits": limits})
    rows = ["measure,value,fraction"]
    for fraction in (0.25, 0.5, 0.75, 1):
        step = stiff.with_values({"move[1].by": [0.4 * fraction, 0, 0.4 * fraction]}).run("coupled", tolerance=1e-7)
        rows.append(f"pull_x,{step.measures['pull'][0]!r},{fraction}")
    (tmp_path / "curve.csv").write_text("\n".join(rows) + "\n")
    one = maille.identify(stiff.with_values({E: "60 kPa"}), tmp_path / "curve.csv", [E])
    assert one.status == "done" and one[E].value == pytest.approx(30, rel=1e-3)
    assert [each.fraction for each in one.observations] == [0.25, 0.5, 0.75, 1]
    with pytest.raises(maille.SceneFaults, match="curve.csv:2: fraction: expected .*at most 1, found \"2\""):
        (tmp_path / "curve.csv").write_text("measure,value,fraction\npull_x,1,2\n")
        maille.identify(stiff, tmp_path / "curve.csv", [E])


def test_identify_contract_ctrl_c_gives_the_best_so_far():
    large = maille.Scene(maille.box((60, 40, 40), "1 mm", {"youngs_modulus": "10 kPa", "poisson_ratio": 0.3}), [maille.hold("x-")],
                         [maille.move("x+", by=("1 mm", 0, 0))], measures=[maille.measure("pull", force="move[1]")])
    press_ctrl_c(0.5)
    one = maille.identify(large, {"pull_x": "0.1 N"}, ["specimen.material.youngs_modulus"])
    assert one.status == "interrupted" and one.unknowns[0].value > 0
