"""Finite elements from Python: optional, and loaded only when they are asked."""

import signal
import time

import numpy as np
import pytest

import maille
import maille.fem
from conftest import STRIP, ended, label_scene, press_ctrl_c, two_labels

needs_fem = pytest.mark.skipif(not maille.fem.is_available(), reason="the target _fem was not built")


def test_fem_contract_is_loaded_when_it_is_first_asked():
    """Neither ``import maille`` nor ``import maille.fem`` loads deal.II; without it a sentence says what is missing."""
    run = ended("import maille, maille.fem, sys\n"
                "maps = open('/proc/self/maps').read()\n"
                "assert not any(word in maps for word in ('deal_II', 'libvtk', 'libmpi', 'rilinos')), maps\n"
                "assert 'maille._fem' not in sys.modules")
    assert run.returncode == 0, run.stderr
    run = ended("import sys\nsys.modules['maille._fem'] = None\nimport maille, maille.fem\n"
                "assert not maille.fem.is_available()\n"
                "scene = maille.Scene(maille.box((2, 2, 2), '1 mm', 'muscle/soleus'), holds=[maille.hold('x-')])\n"
                "try:\n    scene.run('fem_q1')\nexcept ImportError as error:\n    print(error)")
    assert run.returncode == 0 and "MAILLE_PYTHON_FEM=ON" in run.stdout, run.stderr


@needs_fem
def test_fem_analytic_a_bar_in_uniaxial_stress(tmp_path):
    """Truth: Hooke's law. Sides are free, ends are guided: stress is E u / L everywhere, and sides draw in by nu."""
    (tmp_path / "bar.toml").write_text(
        STRIP.replace('where = "x-"', 'where = "x-"\naxes = "x"\n[[hold]]\nwhere = "y-"\naxes = "y"\n'
                                      '[[hold]]\nwhere = "z-"\naxes = "z"')
             .replace('by = ["0.4 mm", 0, 0]', 'by = ["0.4 mm", 0, 0]\naxes = "x"'))
    scene = maille.load(tmp_path / "bar.toml")
    for method in ("fem_q1", "fem_q2"):
        answer = scene.run(method)
        assert answer.status == "done" and answer.method == method
        x = np.linspace(0, 8e-3, 9)
        assert answer.displacement[2, 2, :, 0] == pytest.approx(0.05 * x, abs=1e-9)
        assert answer.displacement[4, 2, :, 2] == pytest.approx(np.full(9, -0.3 * 0.05 * 4e-3), rel=1e-6)
        assert answer.moves[0]["force"][0] == pytest.approx(10e3 * 0.05 * 16e-6, rel=1e-6)
        assert answer.displacement.base is not None and not answer.displacement.flags.writeable


@needs_fem
def test_fem_contract_measures_the_other_methods():
    compared = label_scene(two_labels()).compare(("limits", "coupled"), reference="fem_q1")
    errors = {row["method"]: row.get("relative_l2") for row in compared.rows}
    assert errors["fem_q1"] is None and 0 < errors["coupled"] < errors["limits"]
    with pytest.raises(ValueError, match="fem_q1 or fem_q2"):
        maille.fem.run(label_scene(two_labels()), "fem_q3")


@needs_fem
def test_fem_contract_ctrl_c_and_progress_end_a_run():
    scene = maille.Scene(maille.box((40, 40, 40), "1 mm", {"youngs_modulus": "10 kPa", "poisson_ratio": 0.3}),
                         holds=[maille.hold("x-")], moves=[maille.move("x+", by=(0, "1 mm", 0))])
    press_ctrl_c(0.2)
    begin = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        scene.run("fem_q1", threads=1)
        while time.perf_counter() < begin + 30:  # a machine so fast that it was done
            time.sleep(0.01)

    def enough(fraction, what):
        raise ArithmeticError(what)

    with pytest.raises(ArithmeticError):
        scene.run("fem_q1", threads=1, progress=enough)
    assert signal.getsignal(signal.SIGTERM) == signal.SIG_DFL


@needs_fem
def test_fem_contract_an_interpreter_ends_well_with_work_left_behind():
    """A step that cannot be stopped is left to itself; Python then ends with its own exit code, and at once."""
    run = ended("import maille, maille.fem, sys\n"
                "scene = maille.Scene(maille.box((48, 48, 48), '1 mm', 'muscle/soleus'), holds=[maille.hold('x-')],\n"
                "                     moves=[maille.move('x+', by=(0, '1 mm', 0))])\n"
                "def enough(fraction, what):\n    raise ArithmeticError(what)\n"
                "try:\n    scene.run('fem_q2', threads=1, progress=enough)\n"
                "except ArithmeticError:\n    pass\n"
                "print('left behind:', maille.fem._module().works_left_behind())\n"
                "sys.exit(3)")
    assert run.returncode == 3, run.stderr
    assert run.stdout == "left behind: 1\n", "else nothing was tried"
