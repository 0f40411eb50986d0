"""One page (HTML) of a folder of results.

The files in the folder are the input, and may be anything: files are read up to a size, texts are escaped, and a
file that is not what it seems costs its own section, which a note says. The page loads nothing: pictures and plots
are data URIs, and its policy forbids requests. Bodies are drawn by VTK in the command, which hands the pictures over.
"""

from __future__ import annotations

import base64
import os
import time
import urllib.parse
import warnings
from pathlib import Path
from typing import Any, Dict, List, Optional, Tuple, Union

from ._command import run
from ._faults import MailleWarning
from ._program import UsageError, complain, print_safely, write_whole
from ._report_answers import answers_section
from ._report_parts import Data, at, distinct, in_bytes, listed, number, parse, plain, read, words
from ._report_studies import play_section, probe_section, study_section, trade_section

LARGEST_PICTURE, LARGEST_PICTURES = 16 << 20, 96 << 20  #: [bytes] of one, of all on a page
LARGEST_TABLE, LARGEST_JSON = 256 << 20, 256 << 20  #: [bytes] of a study's table, of all JSON files
MOST_FILES = 2000  #: that a page lists
GENERATOR = b'<meta name="generator" content="maille'  #: in the head of every page


class _Folder:
    """The files of a folder, without pages such as this, and what is known of them."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.files = sorted(file for file in path.iterdir() if file.is_file() and file.suffix != ".html" and not file.name.startswith("."))
        self.notes: List[str] = []
        self.json = self._parsed()
        self.pictures = self._good_pictures()

    def _parsed(self) -> Dict[str, Any]:
        parsed, left = {}, LARGEST_JSON
        for file in self.files:
            if file.suffix == ".json":
                try:
                    content = read(file)
                    left -= len(content)
                    if left < 0:
                        raise UsageError(f"{file}: left out, since the folder's JSON is larger than {in_bytes(LARGEST_JSON)}")
                    parsed[file.name] = parse(content, file)
                except (UsageError, OSError) as error:
                    self.notes.append(str(error))
        return parsed

    def _good_pictures(self) -> List[Path]:
        """A PNG beside an SVG of its name is the same picture."""
        names, left, pictures = {file.name for file in self.files}, LARGEST_PICTURES, []
        for file in self.files:
            if file.suffix != ".svg" and (file.suffix != ".png" or file.stem + ".svg" in names):
                continue
            try:
                content = read(file, LARGEST_PICTURE)
                if not (content.startswith(b"\x89PNG") if file.suffix == ".png" else b"<svg" in content):
                    raise UsageError(f"{file}: no picture, though its name says so: left out")
                left -= len(content)
                if left < 0:
                    raise UsageError(f"{file}: left out, since the folder's pictures are larger than {in_bytes(LARGEST_PICTURES)}")
                pictures.append(file)
            except (UsageError, OSError) as error:
                self.notes.append(str(error))
        return pictures

    def take(self, belongs: Any) -> List[Path]:
        """Takes those out of the pictures that belong to a section."""
        taken = [file for file in self.pictures if belongs(file)]
        self.pictures = [file for file in self.pictures if file not in taken]
        return taken

    def rows(self, file: Path) -> List[Data]:
        """Of a study's table. A last line that is not whole, as a study that was killed leaves, is passed over."""
        rows = []
        for line in read(file, LARGEST_TABLE).splitlines():
            try:
                row = parse(line, file)
            except UsageError:
                continue
            if isinstance(row, dict) and "method" in row:
                rows.append(row)
        return rows


def _picture(file: Path, alt: str, caption: str) -> Data:
    kind = "image/svg+xml" if file.suffix == ".svg" else "image/png"
    return {"source": f"data:{kind};base64,{base64.b64encode(read(file)).decode()}", "look": "picture", "alt": alt, "caption": caption}


def _is_frames(data: Any) -> bool:
    return isinstance(at(data, "trajectory"), str) and isinstance(at(data, "frames"), list) and isinstance(at(data, "objects"), list)


def _is_probe(data: Any) -> bool:
    return number(data, "ticks") is not None and isinstance(at(data, "passivity"), dict) and isinstance(at(data, "force"), dict)


def _play(folder: _Folder, data: Data) -> Optional[Data]:
    """By what the play wrote into the folder, and by its frames where those are there too."""
    same = [other for other in folder.json.values() if at(other, "scene") == at(data, "scene")]
    if at(data, "kind") != "play":
        return None if any(at(other, "kind") == "play" for other in same) else play_section(None, data, [])
    stem = plain(at(data, "scene")) + "_"
    moments = folder.take(lambda file: file.stem.startswith(stem) and file.stem[len(stem) :].isdecimal())
    shown = moments if len(moments) <= 4 else [moments[i * (len(moments) - 1) // 3] for i in range(4)]
    pictures = [_picture(file, f"The world at one moment: {file.name}", file.name) for file in shown]
    return play_section(data, next((other for other in same if _is_frames(other)), None), pictures)


def _section(folder: _Folder, file: Path, drawn: Data) -> Optional[Data]:
    """The section of one file, if it is of results."""
    if file.suffix == ".jsonl":
        rows = [] if file.stem.endswith("_older") else folder.rows(file)
        return study_section(rows, file.stem, folder.json.get(file.stem + "_about.json")) if rows else None
    data: Any = folder.json.get(file.name)
    kind = at(data, "kind")

    def own(alt: str, caption: str) -> List[Data]:
        return [_picture(one, alt, caption) for one in folder.take(lambda picture: picture.stem == file.stem)]

    if kind in ("compare", "run"):
        return answers_section(data, drawn)
    if kind == "play" or _is_frames(data):
        return _play(folder, data)
    if _is_probe(data):
        return probe_section(data, file.stem, own("Force and latency over time; the table has the figures", "Over time"))
    if isinstance(at(data, "rows"), list) and isinstance(at(data, "reference_algorithm"), str):
        return trade_section(data, own("Fronts of error over time and over memory; the table has the figures",
                                       "Error over time and over memory, with the fronts of what nothing beats"))  # fmt: skip
    return None


def _sections(folder: _Folder, drawn: Dict[str, Data]) -> List[Data]:
    sections: List[Data] = []
    for file in folder.files:
        try:
            section = _section(folder, file, drawn.get(file.name, {}))
        except UsageError as error:
            folder.notes.append(str(error))
        except (ArithmeticError, AttributeError, LookupError, OSError, TypeError, ValueError):
            folder.notes.append(f"{file}: expected results that Maille wrote, found entries of another form")
        else:
            folder.notes += listed(drawn.get(file.name), "notes")
            if section:
                names = {one["id"] for one in sections}
                while section["id"] in names:  # the same scene in two files
                    section["id"] += "-again"
                    for table in [section.get("table"), *section.get("tables", [])]:
                        if table:
                            table.id += "-again"
                sections.append(section)
    return sections


def page(folder: Path, file: Path, command: str, version: str, drawn: Dict[str, Data]) -> Tuple[str, List[str]]:
    """@param file     where the page will stand: links to the folder's files are relative to it
    @param version  of Maille, and its commit
    @param drawn    by name of a file of results: the question in words, pictures of its bodies (a request of the command)
    @return the page, and notes of what is missing on it

    Raises:
        UsageError: a folder without results
    """
    import jinja2
    import markupsafe

    of = _Folder(folder)
    sections = _sections(of, drawn)
    notes = distinct(of.notes)
    if not sections:
        raise UsageError("OUT: expected a folder that compare --out, run --out, study, trade or play --out wrote, found no results in "
                         f'"{folder}"')  # fmt: skip
    title = sections[0]["heading"] if len(sections) == 1 else f"{len(sections)} results"
    if len(sections) == 1:  # the title says what it is about
        sections[0]["heading"] = "Results"
    links = os.path.relpath(folder.resolve(), file.parent.resolve())
    addresses = {one: urllib.parse.quote(os.fsencode(one.name if links == "." else os.path.join(links, one.name))) for one in of.files[:MOST_FILES]}
    templates = jinja2.Environment(loader=jinja2.FileSystemLoader(Path(__file__).parent / "templates"), autoescape=True, keep_trailing_newline=True)
    source = templates.loader.get_source  # type: ignore[union-attr]
    style, script = (markupsafe.Markup(source(templates, name)[0].rstrip()) for name in ("style.css", "sort.js"))
    made = f"made {time.strftime('%Y-%m-%d %H:%M UTC', time.gmtime())} on {os.uname().nodename} by maille {version}".rstrip()
    html = templates.get_template("page.html").render(
        maille=version.split()[0] if version else "", title=title, folder=str(folder), style=style, script=script, notes=notes, sections=sections,
        others=[_picture(one, f"The picture {one.name}", one.name) for one in of.pictures], command=command, made=made,
        files=[{"name": one.name, "address": addresses[one], "size": in_bytes(one.stat().st_size)} for one in addresses])  # fmt: skip
    return "".join(c if c >= " " or c in "\n\t" else "\ufffd" for c in html), notes


def main(request: Data) -> int:
    """Continues `maille report`: the command has checked the options."""
    folder, file = Path(request["folder"]), Path(request["out"])
    html, notes = page(folder, file, request["command"], request["version"], request["drawn"])
    write_whole(file, html.encode(errors="replace"))
    for note in notes:
        complain(note)
    print_safely(f"wrote {file}\n")
    return 0


def report(folder: "Union[str, os.PathLike[str]]", out: "Union[str, os.PathLike[str], None]" = None) -> Path:
    """Makes one page (HTML) of a folder of results, as ``maille report`` does; without the command, no pictures of bodies.

    Args:
        out: FOLDER/report.html where it is None. An earlier page is replaced, any other file is not

    Raises:
        UsageError: no results there, or a foreign file with the page's name
    """
    folder = Path(folder)
    file = Path(out) if out is not None else folder / "report.html"
    try:
        ended = run(["report", str(folder), "--out", str(file)])
        if ended.code != 0:
            raise (UsageError if ended.code == 2 else RuntimeError)(ended.complaint)
        notes = ended.complaint.splitlines()
    except FileNotFoundError:
        if not folder.is_dir():
            raise UsageError(f'OUT: expected a folder of results, found "{folder}"')
        if file.is_symlink() or (file.is_file() and file.stat().st_size and GENERATOR not in file.open("rb").read(1 << 16)):
            raise UsageError(f"--out {file}: expected a new file, or a page that report has written, found another")
        html, notes = page(folder, file, f'maille.report("{folder}")', "", {})
        write_whole(file, html.encode(errors="replace"))
    for note in notes:
        warnings.warn(note, MailleWarning, stacklevel=2)
    return file
