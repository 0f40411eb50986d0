"""Finite elements by deal.II, as a witness: fem_q1 (linear) and fem_q2 (quadratic).

Optional: ``import maille`` does not load it, nor deal.II. ``is_available()`` says whether it was built.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Optional

from ._progress import Progress, told

if TYPE_CHECKING:
    from ._answer import Answer
    from ._scene import Scene


def _module() -> Any:
    try:
        from . import _fem
    except ImportError as error:
        raise ImportError("finite elements are not part of this build of maille: build the target _fem, which needs "
                          "deal.II (cmake --preset release), or install with MAILLE_PYTHON_FEM=ON") from error
    return _fem


def is_available() -> bool:
    """Whether fem_q1 and fem_q2 can be asked."""
    try:
        _module()
    except ImportError:
        return False
    return True


def run(scene: "Scene", method: str = "fem_q1", *, threads: int = 1, seconds: Optional[float] = None,
        progress: Progress = None) -> "Answer":
    """Answers a scene by finite elements on its cells; the displacement is that of its own nodes."""
    from ._answer import Answer

    with told(progress) as tell:
        return Answer(_module().run(scene._built, method, threads, seconds, tell), scene)
