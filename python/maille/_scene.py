"""The question: a body, what holds it, what moves it, what pulls at it."""

from __future__ import annotations

import copy
import os
import re
import warnings
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union, overload

import numpy as np
import numpy.typing as npt

from . import _core, _toml
from ._answer import Answer, Floats, Record, axes_of, compare, vectors_in
from ._faults import MailleWarning, SceneFaults, count, existing, number_above_0
from ._images import Image, Rows
from ._program import refuse_foreign, write_whole
from ._progress import Progress, told
from ._series import Series, run_steps

if TYPE_CHECKING:
    from ._cases import Study

Table = Dict[str, Any]
Where = Union[str, Mapping[str, Any]]
Length = Union[float, str]
PathLike = Union[str, "os.PathLike[str]"]

FEM_METHODS = ("fem_q1", "fem_q2")


def hold(where: Where, axes: Optional[str] = None, *, frame: Optional[str] = None) -> Table:
    """Nodes that are kept where they are, as ``[[hold]]`` of a scene file.

    Args:
        where: a face (``x-``), or a region as scene files have it: ``{"label": 17, "touching": 30}``
        axes: components, such as ``xz``; all without it
        frame: of the places in ``where``: ``grid`` (the body's own axes, default), ``world``, ``ras`` or ``lps``
    """
    return _without_none(where=where, axes=axes, frame=frame)


def move(where: Where, *, by: Optional[Sequence[Length]] = None, axes: Optional[str] = None,
         turn: Optional[Mapping[str, Any]] = None, frame: Optional[str] = None,
         field: Optional[Mapping[str, Any]] = None) -> Table:
    """Nodes that are put elsewhere, as ``[[move]]``.

    Args:
        where: as of ``hold``
        by: three lengths, such as ``"2 mm"``; bare numbers where the scene has ``units``
        axes: components, such as ``xz``; all without it
        turn: ``{"angle": "20 deg", "axis": (0, 0, 1), "about": ("1 mm", 0, 0)}``
        frame: of ``by``, ``turn`` and places: ``grid`` (the body's own axes, default), ``world``, ``ras`` or ``lps``
        field: displacements from a file in place of ``by``: ``{"image": "u.nii.gz", "unit": "mm"}``
    """
    return _without_none(where=where, by=None if by is None else list(by), axes=axes, turn=turn, frame=frame, field=field)


def load_on(where: Optional[Where] = None, **what: Any) -> Table:
    """A load, as ``[[load]]``: ``traction``, ``force``, ``pressure``, ``gravity`` or ``contraction``, in SI or with a unit."""
    return _without_none(where=where, **what)


def measure(name: str, **what: Any) -> Table:
    """A quantity that is asked of answers, as ``[[measure]]``: ``measure("pull", force="move[1]", component="x")``."""
    return _without_none(name=name, **what)


def box(cells: Sequence[int], spacing: Union[Length, Sequence[Length]], material: Any, **keys: Any) -> Table:
    """A box of cells, as ``[specimen]``: one, two or three numbers of cells, their size ("1 mm"), and what they are of."""
    return {"shape": "box", "cells": list(cells), "spacing": spacing, "material": material, **keys}


def _without_none(**keys: Any) -> Table:
    return {key: value for key, value in keys.items() if value is not None}


@dataclass(frozen=True)
class Report:
    """What ``Scene.check`` found: sizes to look at, and what is out of all proportion."""

    size: Tuple[float, float, float]  #: of the box around the matter [m]
    largest_move: float  #: [m]
    move_over_length: float  #: that over the longest side [1]
    mean_strain: Optional[float]  #: that the moves ask for on the way [1]
    strain_of_loads: Optional[float]  #: largest traction or contraction over the least Young's modulus [1]
    warnings: List[str]  #: what is out of all proportion, in words
    cells: int  #: of matter
    nodes: int  #: of the body
    left_out: List[str]  #: pieces that nothing holds


@dataclass(frozen=True)
class Comparison:
    """Answers of several methods to one question; ``rows`` is a record a method, which pandas reads."""

    answers: Dict[str, Answer]  #: by method
    reference: str  #: the method that the others are measured against
    rows: List[Record]  #: method, status, seconds, bytes, iterations, and the norms of ``Errors``


class Scene:
    """A question that methods answer.

    Lengths and angles are texts with a unit, or ``units`` says what bare numbers are in; other bare numbers are in SI.
    Nothing is read before the scene is first used.
    ``check`` then raises SceneFaults with every fault at once, and so does all else.

    Args:
        specimen: a ``maille.Image`` of labels, a ``box``, or any ``[specimen]`` of a scene file as a mapping
        holds: results of ``hold``
        moves: results of ``move``
        loads: results of ``load_on``
        measures: results of ``measure``
        drives: tables of ``[[drive]]``
        sliding: tables of ``[[sliding]]``: ``{"between": [17, 19], "friction": 0.3}``
        limits: as in scene files (docs/scene.md), like the next four
        relaxation: as in scene files
        test: as in scene files
        title: as in scene files
        strain: as in scene files
        units: of lengths and angles without one, as in scene files: ``"mm"``, ``"m, rad"``
        name: of files and results
        folder: where files that it names are looked for
    """

    def __init__(self, specimen: Union[Image, Mapping[str, Any]], holds: Iterable[Mapping[str, Any]] = (),
                 moves: Iterable[Mapping[str, Any]] = (), loads: Iterable[Mapping[str, Any]] = (),
                 measures: Iterable[Mapping[str, Any]] = (), *, drives: Iterable[Mapping[str, Any]] = (),
                 sliding: Iterable[Mapping[str, Any]] = (), limits: Optional[Mapping[str, Any]] = None,
                 relaxation: Optional[Mapping[str, Any]] = None, test: Optional[Mapping[str, Any]] = None,
                 title: Optional[str] = None, units: Optional[str] = None, strain: Optional[str] = None,
                 name: str = "scene", folder: PathLike = ".") -> None:
        self._image = specimen if isinstance(specimen, Image) else None
        table = specimen.table() if isinstance(specimen, Image) else dict(specimen)
        self._document: Table = _without_none(
            units=units, title=title, strain=strain, specimen=table, limits=limits, relaxation=relaxation, test=test,
            hold=[dict(h) for h in holds] or None, move=[dict(m) for m in moves] or None,
            load=[dict(one) for one in loads] or None, measure=[dict(m) for m in measures] or None,
            drive=[dict(d) for d in drives] or None, sliding=[dict(pair) for pair in sliding] or None)
        self._name = name
        self._folder = os.fspath(folder)
        self._text: Optional[str] = None
        self._made: Optional[_core.Scene] = None

    @classmethod
    def from_dict(cls, document: Mapping[str, Any], *, name: str = "scene", folder: PathLike = ".") -> "Scene":
        """A scene file as a mapping, keys as in the file."""
        scene = cls({}, name=name, folder=folder)
        scene._document = copy.deepcopy(dict(document))
        return scene

    @classmethod
    def from_file(cls, file: PathLike) -> "Scene":
        """Reads a scene file.

        Raises:
            FileNotFoundError: there is no such file
            SceneFaults: every fault, with its line and key
        """
        path = Path(existing(file))
        core = _core.read_scene(os.fspath(path))
        scene = cls({}, name=path.stem, folder=path.parent)
        scene._text = path.read_text(encoding="utf-8")
        scene._made = core
        scene._document = _parsed(scene._text)
        return scene

    def __repr__(self) -> str:
        return f"<maille.Scene {self._name!r}>"

    def _repr_html_(self) -> str:
        from ._html import scene_html

        return scene_html(self)

    # ---- what it is --------------------------------------------------------------------------------------------

    @property
    def _built(self) -> _core.Scene:
        if self._made is None:
            if self._image is not None:
                self._made = _core.build_scene(self._name, self._image.voxels(), self._image.rows(),
                                               self._image.affine is not None, _toml.plain(self._document), self._folder)
            else:
                self._made = self._parsed()
        return self._made

    def _parsed(self) -> _core.Scene:
        if self._text is not None:
            return _core.parse_scene(self._text, os.path.join(self._folder, self._name + ".toml"))
        return _core.build_keys(self._name, _toml.plain(self._document), self._folder)

    def __getstate__(self) -> Dict[str, Any]:
        """Without what was read: a copy, in another process too, reads it anew."""
        return {**self.__dict__, "_made": None, "_folder": os.path.abspath(self._folder)}

    @property
    def name(self) -> str:
        """The file's name without its ending."""
        return self._name

    @property
    def title(self) -> str:
        """Of the file, or its name."""
        return self._built.title

    @property
    def dimension(self) -> int:
        """1, 2 or 3."""
        return self._built.dimension

    @property
    def cells(self) -> Tuple[int, int, int]:
        """Cells of the grid along x, y, z; it is just large enough for the matter."""
        x, y, z = self._built.cells
        return x, y, z

    @property
    def nodes(self) -> Tuple[int, int, int]:
        """Nodes of the grid along x, y, z."""
        x, y, z = self._built.nodes
        return x, y, z

    @property
    def spacing(self) -> Tuple[float, float, float]:
        """Of cells [m]."""
        x, y, z = self._built.spacing
        return x, y, z

    @property
    def node_affine(self) -> Floats:
        """From indices (i, j, k, 1) of nodes to where they rest in the world: 4 x 4 [m]."""
        return np.array(self._built.node_affine)

    @property
    def materials(self) -> List[str]:
        """Names, by their numbers in ``material_id``."""
        return self._built.materials

    @property
    def material_id(self) -> npt.NDArray[np.uint8]:
        """The material of every cell: array (cz, cy, cx); 255: no matter. A view."""
        return self._built.material_id

    @property
    def labels(self) -> Optional[npt.NDArray[np.int32]]:
        """The label of every cell: array (cz, cy, cx), 0 without matter; None where the body is no segmentation."""
        return self._built.labels

    def nodes_in(self, where: Where) -> npt.NDArray[np.int64]:
        """Numbers of the body's nodes in a region: i + nx (j + ny k)."""
        return self._built.nodes_in(where if isinstance(where, str) else {"where": _toml.plain(where)})

    def document(self) -> Table:
        """The scene as a mapping, as ``from_dict`` takes it; of a body in memory without its image."""
        return copy.deepcopy(self._document)

    # ---- what is asked of it -----------------------------------------------------------------------------------

    def check(self) -> Report:
        """Reads the scene and looks at its proportions; nothing is solved.

        Raises:
            SceneFaults: every fault at once: key, what was expected, what was found
        """
        return Report(**self._built.check())

    @overload
    def run(self, method: str = "coupled", *, steps: None = None, tolerance: Optional[float] = None, threads: Optional[int] = None,
            seconds: Optional[float] = None, bytes: Optional[int] = None, progress: Progress = None, frame: str = "world") -> Answer: ...

    @overload
    def run(self, method: str = "coupled", *, steps: int, tolerance: Optional[float] = None, threads: Optional[int] = None,
            seconds: Optional[float] = None, bytes: Optional[int] = None, progress: Progress = None, frame: str = "world") -> Series: ...

    def run(self, method: str = "coupled", *, steps: Optional[int] = None, tolerance: Optional[float] = None, threads: Optional[int] = None,
            seconds: Optional[float] = None, bytes: Optional[int] = None,
            progress: Progress = None, frame: str = "world") -> Union[Answer, Series]:
        """Answers the scene by one method; see ``maille.methods()``, and ``maille.fem`` for fem_q1 and fem_q2.

        Warnings of the command are MailleWarnings, and in ``Answer.warnings``. Other Python threads run meanwhile. Ctrl-C stops it and
        raises KeyboardInterrupt; an exception of ``progress`` stops it, too.

        Args:
            steps: a Series of that many answers, each starting from the last; ``seconds`` is then a step's. Ctrl-C keeps what is there
            tolerance: estimated remaining error over the largest prescribed displacement, 0 to 1
            threads: default: as many as there are processors; the same bits for any number
            seconds: a budget: what is there by then, with status budget_reached
            bytes: memory that the method may take; what does not fit is refused before anything is allocated
            progress: True for a bar (tqdm's where it is installed), or a function called some 20 times a second at most with the
                fraction done and what is being done
            frame: of the answer's arrays: ``world``, as of files and forces, or ``grid``, the image's own axes
        """
        threads = count("threads", threads or os.cpu_count() or 1)
        tolerance = None if tolerance is None else number_above_0("tolerance", tolerance, "1e-6")
        seconds = None if seconds is None else number_above_0("seconds", seconds, "10", or_0=True)
        bytes = None if bytes is None else count("bytes", bytes)
        if method not in (*_core.methods(), *FEM_METHODS):
            raise ValueError(f"expected one of {', '.join([*_core.methods(), *FEM_METHODS])}, found {method!r}")
        with told(progress) as tell:
            if steps is not None:
                found: Union[Answer, Series] = run_steps(self, method, steps, tolerance, threads, seconds, bytes, tell, frame)
            elif method in FEM_METHODS:
                from . import fem

                found = fem.run(self, method, threads=threads, seconds=seconds, progress=tell).in_frame(frame)
            else:
                found = Answer(self._built.run(method, tolerance, threads, seconds, bytes, tell), self, frame)
        for warning in dict.fromkeys(warning for answer in (found if isinstance(found, Series) else [found]) for warning in answer.warnings):
            warnings.warn(warning, MailleWarning, stacklevel=2)
        return found

    def compare(self, methods: Sequence[str] = ("limits", "relaxed", "coupled"), *, reference: str = "coupled",
                threads: Optional[int] = None, progress: Progress = None) -> Comparison:
        """Answers the scene by several methods, and measures each against ``reference``, which is asked too."""
        answers: Dict[str, Answer] = {}
        for method in [*methods, *(() if reference in methods else (reference,))]:
            answers[method] = self.run(method, threads=threads, progress=progress)
        rows: List[Record] = []
        for method, answer in answers.items():
            row: Record = {"method": method, "status": answer.status, "seconds": answer.seconds,
                           "bytes": answer.bytes, "iterations": answer.iterations}
            both = answer._core.has_displacement and answers[reference]._core.has_displacement
            if method != reference and both:
                row.update(vars(compare(answer, reference=answers[reference])))
            rows.append(row)
        return Comparison(answers, reference, rows)

    def study(self, vary: Mapping[str, Any], **options: Any) -> "Study":
        """``maille.study`` of this scene."""
        from ._cases import study

        return study(self, vary, **options)

    def with_values(self, values: Mapping[str, Any]) -> "Scene":
        """A copy with other values of some keys, named as in files, lists counted from 1: ``move[1].by``, ``specimen.labels.17``."""
        varied = copy.copy(self)
        varied._document = copy.deepcopy(self._document)
        varied._text = varied._made = None
        for key, value in values.items():
            _set(varied._document, key, value)
        return varied

    def drag(self, *, threads: int = 1, frame: str = "world") -> "Drag":
        """The body in a hand, step by step, within the limits of its links; ``frame`` as of ``run``. See ``Drag``."""
        return Drag(self, threads, frame)

    # ---- files -------------------------------------------------------------------------------------------------

    def save(self, file: PathLike, note: str = "", *, overwrite: bool = False) -> None:
        """Writes the scene as a file, and labels in memory as ``NAME_labels.nii.gz`` beside it.

        Files that it names are written as paths from there; ``note`` heads it. ``load`` reads it back. A file
        that Maille did not write stays unless ``overwrite``: FileExistsError.
        """
        path = Path(file)
        refuse_foreign(path, overwrite)
        self._built  # a faulty scene is no file
        document = copy.deepcopy(self._document)
        specimen = document.get("specimen", {})
        if self._image is not None:
            image = path.with_name(path.stem + "_labels.nii.gz")
            refuse_foreign(image, overwrite)
            voxels = np.ascontiguousarray(self._image.voxels().T.astype(np.int32))
            _core.write_labels(voxels, self._image.rows(), os.fspath(image))
            document["specimen"] = {"shape": "image", "image": image.name, **specimen}
        elif path.parent.resolve() != Path(self._folder).resolve():
            _move_paths(document, Path(self._folder).resolve(), path.parent.resolve())
        write_whole(path, (f"# {note}\n" if note.startswith("Made by maille ") else f"# Made by maille in Python. {note}".rstrip() + "\n") + _toml.dumps(document))

    def _own_image(self) -> Any:
        """The labels that the body is of: of a file an array on its grid."""
        if self._image is not None:
            return self._image
        if not self._built.image:
            raise ValueError("expected an image of labels: the scene's body is from none")
        return _core.read_voxels(self._built.image).T

    def _grid(self) -> Tuple[Tuple[int, int, int], Rows, str]:
        if self._image is not None:
            i, j, k = self._image.voxels().shape
            return (i, j, k), self._image.rows(), "ras"
        if not self._built.image:
            raise ValueError("expected an image whose grid is meant: the scene's body is from none")
        (i, j, k), rows, world = _core.image_grid(self._built.image)
        return (i, j, k), rows, world


class Drag:
    """A body in the hand: moves handles step by step, at the cost of the nodes that they touch.

    Limits of links alone (chain mail): no forces; plastic, so that the state depends on the path. A handle stays
    where it was put until it is released. Two handles or more that turn together turn the body with them.
    """

    def __init__(self, scene: Scene, threads: int = 1, frame: str = "world") -> None:
        self._scene = scene
        self._axes = axes_of(scene._built, frame)
        self._core = _core.Drag(scene._built, threads)
        self._nodes: Dict[str, npt.NDArray[np.int64]] = {}

    def _numbers(self, where: Union[Where, Sequence[int], npt.NDArray[np.int64]]) -> npt.NDArray[np.int64]:
        if isinstance(where, (str, Mapping)):
            name = where if isinstance(where, str) else _toml.value(where)
            found = self._nodes.get(name)
            if found is None:
                found = self._nodes[name] = self._scene.nodes_in(where)
            return found
        return np.asarray(where, dtype=np.int64)

    def move(self, where: Union[Where, Sequence[int], npt.NDArray[np.int64]], *, by: Sequence[Length]) -> Record:
        """Puts nodes at a displacement from rest, three lengths [m] along the frame; says whether it was cut (``is_cut``).

        Args:
            where: a face, a region, or numbers of nodes (see ``Scene.nodes_in``)
        """
        x, y, z = (one if isinstance(one, float) else _metres(one) for one in by)
        if self._axes is not None:
            x, y, z = (float(one) for one in np.array((x, y, z)) @ self._axes)
        return self._core.move(self._numbers(where), (x, y, z))

    def release(self, where: Union[Where, Sequence[int], npt.NDArray[np.int64]]) -> None:
        """Lets handles go; they stay where they are until something moves them."""
        self._core.release(self._numbers(where))

    @property
    def displacement(self) -> Floats:
        """As it is now [m]: array (nz, ny, nx, 3), as Answer.displacement; a copy, since the body goes on."""
        return vectors_in(self._axes, self._core.displacement)

    @property
    def residue(self) -> float:
        """The largest displacement of one component of any node [m]."""
        return self._core.residue


def _metres(length: Any) -> float:
    if isinstance(length, str):
        found = _core.length(length)
        if found is None:
            raise ValueError(f'expected a length such as "2 mm", found {length!r}')
        return found
    return float(length)


def _parsed(text: str) -> Table:
    import tomllib

    return tomllib.loads(text)


def _set(document: Table, key: str, value: Any) -> None:
    """At ``move[1].by``, lists counted from 1; ``move.0.by`` is the older form."""
    steps = re.sub(r"\[([1-9]\d*)\]", lambda found: f".{int(found.group(1)) - 1}", key).split(".")
    if not all(re.fullmatch(r"[^\[\]]+", step) for step in steps):
        raise ValueError(f"expected a key such as move[1].by, found {key!r}")
    place: Any = document
    try:
        for step in steps[:-1]:
            place = place[int(step) if isinstance(place, list) else step]
        last: Any = int(steps[-1]) if isinstance(place, list) else steps[-1]
        if isinstance(place, list):
            place[last]
        place[last] = value
    except (KeyError, IndexError, TypeError, ValueError):
        raise ValueError(f"expected a key that the scene has, found {key!r}") from None


def _move_paths(document: Table, old: Path, new: Path) -> None:
    """Paths of files, from another folder."""
    def moved(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: moved(item) for key, item in value.items()}
        if isinstance(value, list):
            return [moved(item) for item in value]
        if isinstance(value, str) and not value.startswith(("$", "~", "/")) and (old / value).is_file():
            return os.path.relpath(old / value, new)
        return value

    document.update(moved(dict(document)))


__all__ = ["Comparison", "Drag", "Report", "Scene", "box", "hold", "load_on", "measure", "move"]
