"""Builds the Python module by CMake, for pip: everything else about it is in pyproject.toml.

What CMake installs as its component `python` goes into the wheel. From the environment: MAILLE_PYTHON_FEM=ON adds maille.fem, which needs deal.II
and VTK; MAILLE_BUILD names a build folder of CMake that has the module already, from which it is then packed as it is.
"""
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

SOURCES = pathlib.Path(__file__).resolve().parent


class CMakeBuild(build_ext):
    """The extension `maille._core` stands for all that CMake makes."""

    def run(self):
        if self.inplace:
            sys.exit("maille cannot be installed as editable: build the CMake target _core and name BUILD/python in PYTHONPATH")
        build = os.environ.get("MAILLE_BUILD") or self.built()
        with tempfile.TemporaryDirectory() as prefix:
            subprocess.run(["cmake", "--install", str(build), "--component", "python", "--strip", "--prefix", prefix], check=True)
            packed = pathlib.Path(self.build_lib) / "maille"
            shutil.rmtree(packed, ignore_errors=True)
            shutil.copytree(pathlib.Path(prefix) / "lib/python3/dist-packages/maille", packed)

    def built(self):
        with_fem = os.environ.get("MAILLE_PYTHON_FEM", "OFF")
        build = pathlib.Path(self.build_temp).resolve() / ("with_fem" if with_fem == "ON" else "core")
        settings = {"CMAKE_BUILD_TYPE": "Release", "MAILLE_PYTHON": "ON", "MAILLE_TESTS": "OFF", "MAILLE_FEM": with_fem,
                    "MAILLE_PYTHON_FEM": with_fem, "Python3_EXECUTABLE": sys.executable}
        generator = ["-G", "Ninja"] if shutil.which("ninja") else []
        subprocess.run(["cmake", "-S", str(SOURCES), "-B", str(build), *generator, *(f"-D{name}={value}" for name, value in settings.items())],
                       check=True)
        targets = ["_core", "_fem"] if with_fem == "ON" else ["_core"]
        subprocess.run(["cmake", "--build", str(build), "--parallel", str(len(os.sched_getaffinity(0))), "--target", *targets], check=True)
        return build


setup(packages=[], py_modules=[], ext_modules=[Extension("maille._core", sources=[])], cmdclass={"build_ext": CMakeBuild})
