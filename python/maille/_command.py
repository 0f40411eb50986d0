"""Runs the command ``maille`` for functions of Python that need it: studies, choices, fits, reports.

It runs as a child process that writes its progress to stderr (``MAILLE_PROGRESS``), as to a terminal. Ctrl-C is
passed on: the command writes what is complete, and ends within a second.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import tempfile
from pathlib import Path
from typing import Any, Iterable, List, NamedTuple, Optional, Union

from ._faults import existing
from ._progress import Tell


class Ended(NamedTuple):
    code: int
    output: str
    complaint: str
    is_interrupted: bool


def command() -> str:
    """The program ``maille`` that belongs to this module.

    Raises:
        FileNotFoundError: it is not installed
    """
    package = Path(__file__).resolve().parent
    for place in (package.parents[1] / "maille", package.parents[3] / "bin" / "maille"):
        if place.is_file() and os.access(place, os.X_OK):
            return str(place)
    found = shutil.which("maille")
    if found is None:
        raise FileNotFoundError("expected the program maille beside the Python module or in PATH, found none")
    return found


def scene_files(scenes: Iterable[Any], folder: Union[str, Path]) -> List[str]:
    """Names of the files of scenes. Those in memory are saved, each in a folder of its own: two may have one name."""
    files = []
    for number, one in enumerate(scenes, start=1):
        if isinstance(one, (str, os.PathLike)):
            files.append(str(Path(existing(one)).resolve()))
        else:
            files.append(str(Path(folder) / str(number) / f"{one.name}.toml"))
            os.mkdir(os.path.dirname(files[-1]))
            one.save(files[-1])
    return files


def run(words: List[str], tell: Optional[Tell] = None) -> Ended:
    """Runs ``maille`` with these words to its end.

    Raises:
        FileNotFoundError: the command is not installed
    """
    is_interrupted, complaint = False, ""
    with tempfile.TemporaryFile() as output, tempfile.TemporaryFile() as errors, \
            subprocess.Popen([command(), *words], stdout=output, stderr=errors, env={**os.environ, "MAILLE_PROGRESS": "1"}) as process:  # fmt: skip
        try:
            is_running = True
            while is_running:
                try:
                    is_running = process.poll() is None
                    written = os.pread(errors.fileno(), os.fstat(errors.fileno()).st_size, 0)
                    complaint = written.rpartition(b"\r\x1b[K")[2].decode("utf-8", "replace").strip()  # that stands before a line of progress
                    if tell is not None and (shown := re.fullmatch(r"(\d+) %  (.*)", complaint)):
                        tell(int(shown[1]) / 100, shown[2])
                    process.wait(0.1)  # [s]: the command counts signals within 0.2 s, the terminal's and ours, as one
                except subprocess.TimeoutExpired:
                    pass
                except KeyboardInterrupt:
                    process.send_signal(signal.SIGINT)
                    is_interrupted = True
        except BaseException:  # of the caller's function
            process.terminate()
            raise
        output.seek(0)
        return Ended(process.returncode, output.read().decode("utf-8", "replace"), complaint, is_interrupted)
