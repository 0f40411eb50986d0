"""Maille: voxel models of soft tissue, deformed by neighbour limits and checked against finite elements.

    scene = maille.load("strip.toml")           # or maille.Scene(...) from arrays
    answer = scene.run("coupled")
    answer.displacement                         # numpy array (nz, ny, nx, 3) in metres, in the world's frame

Answers are in SI units. Lengths of a question have a unit ("7.5 mm"), or the scene has ``units="mm"``; affines are
in millimetres, as nibabel has them. Start with help(maille.Scene) and help(maille.Answer); docs/python.md has whole programs.
"""

from __future__ import annotations

from typing import Any, List

import numpy as _numpy

from . import _core

if int(_numpy.__version__.split(".")[0]) >= 2 and not _core.knows_numpy_2:
    raise ImportError(f"maille was built with a pybind11 before 2.12, which knows numpy 1 alone, and numpy {_numpy.__version__} is installed: "
                      "pip install 'numpy<2', or build maille with a newer pybind11")
from ._answer import Answer, Errors, compare
from ._faults import Fault, MailleWarning, SceneFaults
from ._images import Image
from ._series import Series
from ._scene import Comparison, Drag, Report, Scene, PathLike, box, hold, load_on, measure, move
from ._world import Frame, World, drive


def load(file: PathLike) -> Scene:
    """Reads a scene file.

    Raises:
        FileNotFoundError: there is no such file
        SceneFaults: every fault at once, each with its line and key
    """
    return Scene.from_file(file)


def methods() -> List[str]:
    """Names that ``Scene.run`` takes without finite elements (see ``maille.fem``)."""
    return _core.methods()


def materials() -> List[str]:
    """Names of the tissue library."""
    return _core.materials()


# Functions that need SciPy or the command, by module: it is imported by their first use.
_LATER = {"choose": "_choose", "design": "_study", "fit": "_fit", "identify": "_identify", "pareto_front": "_trade", "report": "_report",
          "sensitivity": "_study", "Study": "_cases", "study": "_cases"}


def __getattr__(name: str) -> Any:
    if name in _LATER:
        from importlib import import_module

        return getattr(import_module(f"{__name__}.{_LATER[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = ["Answer", "Comparison", "Drag", "Errors", "Fault", "Frame", "Image", "MailleWarning", "Report", "Scene",
           "SceneFaults", "Series", "Study", "World", "box", "choose", "compare", "design", "drive", "fit", "hold", "identify", "load",
           "load_on", "materials", "measure", "methods", "move", "pareto_front", "report", "sensitivity", "study"]
