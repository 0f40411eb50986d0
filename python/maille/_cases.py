"""Studies from Python: the command runs them beneath, in processes side by side, and its table comes back as rows."""

from __future__ import annotations

import csv
import json
import os
import tempfile
import warnings
from pathlib import Path
from typing import Any, Dict, Iterable, List, Mapping, Optional, Sequence, Union

from . import _toml
from ._answer import Record
from ._command import run, scene_files
from ._faults import MailleWarning, count, existing
from ._progress import Progress, told
from ._scene import PathLike, Scene

Body = Union[Scene, PathLike]


class Study(List[Record]):
    """Rows of a study's table as records, columns as in NAME.csv: ``pandas.DataFrame(rows)`` reads them."""

    def __init__(self, rows: Iterable[Record] = (), title: str = "", records: Sequence[Record] = (), about: Optional[Record] = None) -> None:
        super().__init__(rows)
        self.title = title
        self.records = list(records)  #: the rows as ``study --json`` has them
        self.about: Record = about or {}  #: what NAME_about.json holds: provenance, plan, sensitivity

    def __repr__(self) -> str:
        return f"<maille.Study {self.title!r}: {len(self)} rows>"

    def sensitivity(self) -> List[Record]:
        """Sobol's indices, see ``maille.sensitivity``."""
        from ._study import sensitivity

        return sensitivity(self.records, self.about.get("plan"))

    def plot(self, column: str = "", file: Optional[str] = None) -> Any:
        """A column over what was varied, as ``study --picture`` draws it: a Matplotlib figure. ``file``: .svg or .png, written too.

        Raises:
            ValueError: there is nothing to draw
        """
        from ._plots import save
        from ._study import study_figure

        plan = self.about.get("plan")
        figure = study_figure(self.records, self.title, column, [one["column"] for one in plan["parameters"]] if plan else None)
        if file is not None:
            save(figure, file)
        return figure

    def _repr_html_(self) -> str:
        from ._html import rows_html

        return rows_html(repr(self), self)


def study(of: Union[Body, Sequence[Body]], vary: Optional[Mapping[str, Any]] = None, *, methods: Sequence[str] = ("coupled",),
          reference: str = "none", combine: str = "grid", samples: Optional[int] = None, seed: Optional[int] = None,
          jobs: int = 1, threads: Optional[int] = None, out: Optional[PathLike] = None, resume: bool = False, progress: Progress = None) -> Study:
    """Answers a family of scenes as ``maille study``: rows by case and method.

    Rows that failed say so in ``status``. Ctrl-C: the rows so far, and a MailleWarning; KeyboardInterrupt where there are none.

    Args:
        of: a study file; or with ``vary`` a Scene, a scene file, or several
        vary: from keys such as ``move[1].by`` to values, a formula of labels, or ``{"range": [a, b], "count": n, "label": "E"}``
        combine: grid, zip, latin_hypercube, sobol or saltelli, the last three with ``samples``
        jobs: cases at a time
        out: a folder that keeps the table; with ``resume`` the study goes on there
        progress: as of ``Scene.run``

    Raises:
        FileNotFoundError: the command is not installed
        TypeError: a faulty argument
        ValueError: a faulty value, or the command's message
    """
    if vary is None and not isinstance(of, (str, os.PathLike)):
        raise TypeError(f"vary: expected keys of the scene and their values, as only a study file goes without, found none beside {of!r}")
    if vary is not None and not isinstance(vary, Mapping):
        raise TypeError(f"vary: expected a mapping from keys to values, found {vary!r}")
    jobs, threads = count("jobs", jobs), threads if threads is None else count("threads", threads)
    with tempfile.TemporaryDirectory() as temporary:
        file = Path(existing(of)) if vary is None else _written(of, vary, Path(temporary), methods=list(methods), reference=reference,  # type: ignore[arg-type]
                                                                combine=combine, samples=samples, seed=seed)  # fmt: skip
        results = Path(temporary) / "results" if out is None else Path(out)
        words = ["study", os.fspath(file), "--out", os.fspath(results), "--jobs", str(jobs), *(["--resume"] if resume else [])]
        with told(progress) as tell:
            ended = run(words + (["--threads", str(threads)] if threads else []), tell)
        table = results / f"{file.stem}.csv"
        if ended.is_interrupted:
            if not table.is_file():
                raise KeyboardInterrupt
            warnings.warn("interrupted; the rows are those so far", MailleWarning, stacklevel=2)
        elif ended.code not in (0, 1) or not table.is_file():
            raise ValueError(ended.complaint or f"maille study ended with exit code {ended.code}")
        from ._study import read_rows

        about = results / f"{file.stem}_about.json"
        return Study(_rows(table), file.stem, read_rows(table.with_suffix(".jsonl")), json.loads(about.read_text("utf-8")) if about.is_file() else None)


def _written(of: Any, vary: Mapping[str, Any], folder: Path, **keys: Any) -> Path:
    """The study as a file, with scenes in memory beside it."""
    scenes = scene_files([of] if isinstance(of, (Scene, str, os.PathLike)) else of, folder)

    def parameter(key: str, values: Any) -> Dict[str, Any]:
        given = values if isinstance(values, Mapping) else {"values": values if isinstance(values, str) else list(values)}
        return {"label": key, **given} if isinstance(values, str) and "." not in key else {"key": key, **given}

    document = {"scene": scenes, **keys, "parameter": [parameter(*one) for one in vary.items()]}
    path = folder / "study.toml"
    path.write_text(_toml.dumps(document), encoding="utf-8")
    return path


def _value(cell: str) -> Any:
    if cell == "":
        return None
    for kind in (int, float):
        try:
            return kind(cell)
        except ValueError:
            pass
    return cell


def _rows(table: Path) -> List[Record]:
    with open(table, encoding="utf-8", newline="") as stream:
        return [{key: _value(cell) for key, cell in row.items()} for row in csv.DictReader(stream)]


__all__ = ["Study", "study"]
