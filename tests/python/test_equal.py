"""Python as an equal of the command: steps, pickles, studies, what notebooks show."""

import ast
import csv
import json
import multiprocessing
import os
import pickle
import re
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import STRIP, ended, label_scene, press_ctrl_c, two_labels

import maille

SOURCES = Path(__file__).resolve().parents[2]
command = pytest.mark.skipif("MAILLE_COMMAND" not in os.environ, reason="the command is not built")


@command
@pytest.mark.parametrize("method", ["coupled", "relaxed"])
def test_steps_oracle_are_those_of_the_command(strip, tmp_path, method):
    """Truth: the table of `maille run --steps`, of nine digits."""
    subprocess.run([os.environ["MAILLE_COMMAND"], "run", strip, "--methods", method, "--steps", "3", "--out", tmp_path / "out"], check=True, stdout=subprocess.DEVNULL)
    with open(tmp_path / f"out/strip_{method}_force.csv", newline="") as stream:
        rows = list(csv.DictReader(stream))
    series = maille.load(strip).run(method, steps=3)
    curve = series.curve()
    assert len(rows) == len(curve) == len(series) == 3 and list(curve[0]) == list(rows[0])
    for row, told in zip(curve, rows):
        for name, value in row.items():
            assert value == pytest.approx(float(told[name]), rel=1e-6, abs=1e-12), name
    assert series.status == "done" and series.fractions.tolist() == [1 / 3, 2 / 3, 1]
    assert series.forces[:, 0] == pytest.approx([row["move_force_x_n"] for row in curve])
    assert series.plot(str(tmp_path / "force.svg")) is not None and (tmp_path / "force.svg").stat().st_size > 5000


def test_steps_contract_ctrl_c_keeps_what_is_there():
    scene = maille.Scene(maille.box((60, 40, 40), "1 mm", "muscle/soleus", fibre=[1, 0, 0]), holds=[maille.hold("x-")], moves=[maille.move("x+", by=("1 mm", 0, 0))])
    pressed = []

    def progress(fraction, what):
        if fraction > 0.05 and not pressed:
            pressed.append(time.monotonic())
            press_ctrl_c(0)

    begin = time.monotonic()
    with pytest.warns(maille.MailleWarning, match="interrupted after step"):
        series = scene.run("coupled", steps=100, threads=1, progress=progress)
    assert 0 < len(series) < 100 and series.status == "interrupted" and time.monotonic() - pressed[0] < 0.5 * (pressed[0] - begin)
    assert len(series.curve()) == len(series)


BARS = """
import sys, maille
sys.modules.update({without})
bar = maille.Scene(maille.box((30, 20, 20), "1 mm", "muscle/soleus", fibre=[1, 0, 0]), holds=[maille.hold("x-")], moves=[maille.move("x+", by=("1 mm", 0, 0))],
                   measures=[maille.measure("pull", force="move[1]", component="x")])
bar.run(steps=4, progress=True)
maille.identify(bar, {{"pull": bar.run().measures["pull"] * 1.1}}, "E_fibre of muscle/soleus", progress=True)
bar.study({{"move[1].by": [[f"{{n / 100}} mm", 0, 0] for n in range(1, 31)]}}, progress=True)
"""


@command
@pytest.mark.parametrize("without", [{}, {"tqdm": None}])
def test_progress_contract_true_draws_a_bar(without):
    """By tqdm, and without it a line; of a child process its own."""
    run = ended(BARS.format(without=without))
    assert run.returncode == 0 and ("%|" in run.stderr) is not bool(without), run.stderr
    assert all(said in run.stderr for said in ("solving", "answers, misfit", "of 30 cases")), run.stderr


def test_numpy_contract_no_name_that_numpy_2_removed():
    # Of numpy 2's migration guide, what a program may have.
    removed = """alltrue asfarray byte_bounds cast cfloat complex_ cumproduct disp find_common_type float_ in1d Inf Infinity infty issctype issubclass_ longcomplex
    longfloat mat msort NaN nbytes NINF NZERO PINF product PZERO recfromcsv row_stack round_ safe_eval sctypes singlecomplex sometrue string_ trapz unicode_""".split()
    texts = [file.read_text("utf-8") for folder in ("python", "docs/notebooks") for file in (SOURCES / folder).rglob("*") if file.suffix in (".py", ".ipynb")]
    used = {name for text in texts for name in re.findall(r"\b(?:np|numpy|_numpy)\.(\w+)", text)}
    assert "asarray" in used and not used & set(removed)


def equal(one, other):
    names = ("method", "algorithm", "status", "message", "seconds", "iterations", "residual", "bytes", "strain_energy", "fraction", "warnings",
             "labels", "materials", "holds", "moves", "loads", "measures")
    assert all(getattr(one, name) == getattr(other, name) for name in names)
    assert np.array_equal(one.displacement, other.displacement) and np.array_equal(one.stress, other.stress)
    return True


def test_pickles_oracle_are_equal_to_the_bit(strip):
    """Truth: the answers before."""
    labels = two_labels()
    image = pickle.loads(pickle.dumps(maille.Image(labels, labels={17: "muscle/soleus"}, fibre=(1, 0, 0))))
    assert np.array_equal(image.array, labels) and image.labels == {17: "muscle/soleus"}
    sliding = label_scene(labels, sliding=[{"between": [17, 5], "friction": 0.3}], measures=[maille.measure("pull", force="move[1]", component="z")])
    for answer in (sliding.run(), maille.load(strip).run(tolerance=1e-6, frame="grid"), *maille.load(strip).run(steps=2)):
        again = pickle.loads(pickle.dumps(answer))
        assert equal(answer, again) and again.frame == answer.frame
    series = maille.load(strip).run(steps=2)
    again = pickle.loads(pickle.dumps(series))
    assert isinstance(again, maille.Series) and again.steps == 2 and again.curve() == series.curve()
    warped = sliding.run()
    assert np.array_equal(pickle.loads(pickle.dumps(warped)).warp(labels), warped.warp(labels))
    refused = sliding.run(bytes=1)
    assert pickle.loads(pickle.dumps(refused)).message == refused.message != ""
    with pytest.raises(ValueError, match="another grid"):
        maille._core.answer_of(maille.load(strip)._built, warped._core.state())


def force_of(scene):
    return scene.run("coupled", threads=1)


def test_pickles_oracle_a_pool_answers_as_one_process(strip):
    """Truth: the same scenes in this process."""
    scenes = [maille.load(strip).with_values({"move[1].by": [f"0.{n} mm", 0, 0]}) for n in (1, 2, 3)] + [label_scene(two_labels())]
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        answers = pool.map(force_of, scenes)
    for scene, answer in zip(scenes, answers):
        assert np.array_equal(answer.displacement, force_of(scene).displacement) and answer.moves[0]["force"] == force_of(scene).moves[0]["force"]


@command
def test_studies_oracle_are_those_of_scenes(strip, tmp_path):
    """Truth: each case as a scene of its own."""
    scene = maille.load(strip)
    values = ["5 kPa", "20 kPa"]
    rows = maille.study(scene, {"specimen.material.youngs_modulus": values, "move[1].by": [["0.1 mm", 0, 0], ["0.2 mm", 0, 0]]}, methods=("relaxed", "coupled"))
    assert len(rows) == 8 and all(row["status"] == "done" for row in rows) and isinstance(rows, maille.Study)
    column = next(name for name in rows[0] if "youngs_modulus" in name)
    assert column.endswith("]") and {row[column] for row in rows} == {5, 20}
    for value, row in zip(values, rows[1::4]):
        answer = scene.with_values({"specimen.material.youngs_modulus": value, "move[1].by": ["0.1 mm", 0, 0]}).run()
        assert row["method"] == "coupled" and row["strain_energy"] == pytest.approx(answer.strain_energy, rel=1e-4)
    sampled = maille.study([strip], {"specimen.material.youngs_modulus": {"range": ["5 kPa", "20 kPa"]}, "specimen.material.poisson_ratio": {"range": [0.1, 0.4]}},
                           combine="saltelli", samples=8, methods=("relaxed",), out=tmp_path / "kept")
    assert sampled.sensitivity() and len(sampled) == 32
    assert sampled.plot(file=str(tmp_path / "s.png")) is not None
    again = maille.study([strip], {"specimen.material.youngs_modulus": {"range": ["5 kPa", "20 kPa"]}, "specimen.material.poisson_ratio": {"range": [0.1, 0.4]}},
                         combine="saltelli", samples=8, methods=("relaxed",), out=tmp_path / "kept", resume=True)
    assert [row["force"] for row in again] == [row["force"] for row in sampled]
    with pytest.raises(ValueError, match="kept"):
        maille.study([strip], {"specimen.material.poisson_ratio": [0.1]}, out=tmp_path / "kept")
    with pytest.raises(ValueError, match="specimen.colour"):
        maille.study(scene, {"specimen.colour": [1, 2]})


def test_notebooks_contract_show_scenes_and_answers(strip, tmp_path):
    scene = label_scene(two_labels(), title="<b>two</b>")
    answer = scene.run()
    shown = scene._repr_html_() + answer._repr_html_() + scene.run(steps=2)._repr_html_() + scene.run(bytes=1)._repr_html_()
    assert "<b>two</b>" not in shown and "&lt;b&gt;two" in shown
    for word in ("muscle/soleus", "cells", "done", "von Mises", "mm^3", "refused", "largest_displacement_m"):
        assert word in shown, word
    assert "expected" in maille.Scene(maille.box((2, 0), "1 mm", "none"))._repr_html_()
    for field in ("displacement", "von_mises", "label", answer.strain[..., 0]):
        figure = answer.plot(field, file=tmp_path / "slice.png")
        assert len(figure._repr_png_()) > 5000 and (tmp_path / "slice.png").stat().st_size > 5000
    with pytest.raises(ValueError, match="expected one of"):
        answer.plot("colour")


@command
@pytest.mark.parametrize("notebook", sorted((SOURCES / "docs/notebooks").glob("*.ipynb")), ids=lambda path: path.stem)
def test_notebooks_contract_run_from_top_to_bottom(notebook, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    document = json.loads(notebook.read_text(encoding="utf-8"))
    assert document["nbformat"] == 4 and document["cells"][0]["cell_type"] == "markdown"
    names, begin = {"__name__": notebook.stem}, time.monotonic()
    for cell in document["cells"]:
        if cell["cell_type"] == "code":
            *lines, last = ast.parse("".join(cell["source"])).body
            exec(compile(ast.Module(lines, []), str(notebook), "exec"), names)  # noqa: S102
            if isinstance(last, ast.Expr):  # what a notebook shows below the cell
                shown = eval(compile(ast.Expression(last.value), str(notebook), "eval"), names)  # noqa: S307
                for show in ("_repr_html_", "_repr_png_"):
                    made = getattr(shown, show, lambda: None)()
                    assert made is None or len(made) > 50
            else:
                exec(compile(ast.Module([last], []), str(notebook), "exec"), names)  # noqa: S102
    assert time.monotonic() - begin < 20
