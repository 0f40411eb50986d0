"""What a notebook shows of scenes, answers, worlds and rows: short tables, texts of files escaped."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING, Any, Dict, List, Mapping, Optional, Sequence, Tuple

from ._faults import SceneFaults
from ._words import in_bytes, in_percent, in_seconds, in_unit

if TYPE_CHECKING:
    from ._answer import Answer
    from ._scene import Scene
    from ._world import World

MOST_ROWS = 20


def _table(rows: Sequence[Sequence[Any]], heads: Sequence[str] = ()) -> str:
    lines = ["<tr>" + "".join(f"<th>{escape(head)}</th>" for head in heads) + "</tr>"] if heads else []
    lines += ["<tr>" + "".join(f"<td>{escape('-' if cell is None else str(cell))}</td>" for cell in row) + "</tr>" for row in rows]
    return "<table>" + "".join(lines) + "</table>"


def _titled(title: str, *parts: str) -> str:
    return f"<div><b>{escape(title)}</b>{''.join(parts)}</div>"


def _warnings(texts: Sequence[str]) -> str:
    return "".join(f"<p>warning: {escape(text)}</p>" for text in texts)


def rows_html(title: str, rows: Sequence[Mapping[str, Any]]) -> str:
    """The first rows of a table of records."""
    heads = list(dict.fromkeys(head for row in rows for head in row))

    def cell(value: Any) -> Any:
        return f"{value:.4g}" if isinstance(value, float) else value

    more = f"<p>{len(rows) - MOST_ROWS} more rows</p>" if len(rows) > MOST_ROWS else ""
    return _titled(title, _table([[cell(row.get(head)) for head in heads] for row in rows[:MOST_ROWS]], heads), more)


def scene_html(scene: "Scene") -> str:
    """Size, materials and conditions; of a faulty scene its faults."""
    from ._toml import value

    try:
        found = scene.check()
    except SceneFaults as error:
        return _titled(scene.name, _table([(one.key, one.expected, one.found) for one in error.faults], ("key", "expected", "found")))
    lines: List[Tuple[str, str]] = [
        ("size", " x ".join(f"{1e3 * side:.4g}" for side in found.size[: scene.dimension]) + " mm"),
        ("cells", f"{found.cells} of matter, {' x '.join(f'{1e3 * side:.4g}' for side in scene.spacing[: scene.dimension])} mm; {found.nodes} nodes"),
        ("materials", ", ".join(scene.materials))]  # fmt: skip
    document = scene.document()
    lines += [(f"{name} {number}", value(one)) for name in ("hold", "move", "load", "sliding") for number, one in enumerate(document.get(name) or (), start=1)]
    return _titled(scene.title, _table(lines), _warnings(found.warnings))


_MECHANICS = (("label", "label", ""), ("material", "material", ""), ("volume", "volume", "m^3"), ("change of volume", "volume_change", "%"),
              ("fibre strain", "fibre_strain_mean", "%"), ("fibre stress", "fibre_stress_mean", "Pa"), ("von Mises", "von_mises_mean", "Pa"),
              ("energy", "strain_energy", "J"))  # fmt: skip


def _in_words(value: Any, unit: str) -> Optional[str]:
    if value is None or isinstance(value, str) or unit == "":
        return None if value is None else str(value)
    return in_percent(value) if unit == "%" else in_unit(value, unit)


def answer_html(answer: "Answer") -> str:
    """Status, forces, and mechanics by label or material."""
    head = f"{answer.scene.title} by {answer.method}: {answer.status} in {in_seconds(answer.seconds)}, {in_bytes(answer.bytes)}"
    if not answer._core.has_displacement:
        return _titled(head, f"<p>{escape(answer.message)}</p>")
    largest = max((abs(f) for one in (*answer.moves, *answer.holds) for f in one["force"]), default=0.0)
    forces = [(one["name"], *(f"{f:.4g}" if abs(f) > 1e-6 * largest else "0" for f in one["force"])) for one in (*answer.moves, *answer.holds)]
    parts: List[Dict[str, Any]] = answer.labels or answer.materials
    columns = [column for column in _MECHANICS if any(part.get(column[1]) is not None for part in parts)]
    mechanics = [[_in_words(part.get(key), unit) for _, key, unit in columns] for part in parts]
    per_metre = "/m" if answer.scene.dimension == 2 else ""
    return _titled(head, _table(forces, ("force on", *(f"{axis} [N{per_metre}]" for axis in "xyz"))), _table(mechanics, [name for name, _, _ in columns]),
                   _warnings(answer.warnings))  # fmt: skip


def world_html(world: "World") -> str:
    """Its size, and its objects."""
    size = f"{' x '.join(map(str, world.cells))} cells of {' x '.join(f'{1e3 * side:.4g}' for side in world.spacing)} mm"
    return _titled(world.title, f"<p>{size}</p>", _table(list(world.objects.items()), ("object", "kind")))
