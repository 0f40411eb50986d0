"""pip: the package that it installs, in an environment of its own, from what Debian has."""

import importlib.util
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

SOURCES = Path(__file__).resolve().parents[2]
PACKAGE = Path(os.environ["MAILLE_PYTHON_PATH"])


def pip(*words, python=sys.executable, **environment):
    run = subprocess.run([python, "-m", "pip", "--disable-pip-version-check", *words], capture_output=True, text=True,
                         env={**os.environ, "PIP_NO_INDEX": "1", **environment})
    assert run.returncode == 0, run.stdout + run.stderr


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """Of a copy of what pip needs, so that nothing is written into the sources; compiled is what the build folder has."""
    for needed in ("pip", "setuptools", "wheel"):
        if importlib.util.find_spec(needed) is None:
            pytest.skip(f"python3-{needed} is not installed")
    copy = tmp_path_factory.mktemp("sources")
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE"):
        (copy / name).write_bytes((SOURCES / name).read_bytes())
    out = tmp_path_factory.mktemp("wheel")
    pip("wheel", "--no-build-isolation", "--no-deps", "-w", str(out), str(copy), MAILLE_BUILD=str(PACKAGE.parent))
    wheels = list(out.glob("*.whl"))
    assert len(wheels) == 1
    return wheels[0]


def test_wheels_contract_hold_the_module_and_are_small(wheel):
    names = zipfile.ZipFile(wheel).namelist()
    for name in ("__init__.py", "_core.pyi", "py.typed", "fem.py"):
        assert f"maille/{name}" in names
    assert any(name.startswith("maille/_core.") and name.endswith(".so") for name in names)
    assert not any("test" in name or name.endswith(".a") for name in names)
    mebibytes = wheel.stat().st_size / 2**20
    print({"name": "wheel_mib", "value": mebibytes, "goal": 20})
    assert mebibytes <= 20


def test_installs_contract_in_a_new_environment(wheel, tmp_path):
    environment = tmp_path / "environment"
    subprocess.run([sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", str(environment)], check=True)
    python = str(environment / "bin/python3")
    pip("install", "--no-deps", str(wheel), python=python)
    program = ("import maille\n"
               "scene = maille.Scene(maille.box((8, 4, 4), '1 mm', 'muscle/soleus'), holds=[maille.hold('x-')],\n"
               "                     moves=[maille.move('x+', by=('0.4 mm', 0, 0))])\n"
               "print(maille.__file__, scene.run().status)")
    clean = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    run = subprocess.run([python, "-c", program], cwd=tmp_path, env=clean, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert run.stdout.startswith(str(environment)) and run.stdout.split()[-1] == "done"
