"""Programs that continue the command, in Python.

The command `maille` checks its options, then becomes the program `maille-NAME`. That program reads one JSON
object from standard input, and calls ``main(request)`` of the module ``maille._NAME``, which returns the exit
code. The function that does the work is public (``maille.report``), so that the command and a notebook share it.

Exit codes are the command's: 0 done, 1 the run failed, 2 faulty input, 128 + N stopped by signal N.
"""

from __future__ import annotations

import gzip
import importlib
import io
import json
import mmap
import math
import os
import secrets
import signal
import sys
import warnings
from pathlib import Path
from typing import Any, Dict, List, Optional

from ._faults import SceneFaults


class UsageError(ValueError):
    """The request or a file of the user is faulty: one line, exit code 2."""


def _output(text: str = "") -> None:
    """Prints a text; without one, flushes the output.

    Raises:
        RuntimeError: the output is closed; the interpreter reports it no second time
    """
    try:
        sys.stdout.write(text) if text else sys.stdout.flush()
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
        raise RuntimeError(f"cannot write to standard output: {error.strerror}") from None


_CONTROLS = {code: "?" for code in (*range(9), 11, 12, *range(14, 32), *range(127, 160))}


def print_safely(text: str, stream: Any = None) -> None:
    """Prints for people. Control characters of names and files do not reach the terminal."""
    (stream.write if stream else _output)(text.translate(_CONTROLS))


def complain(message: str) -> None:
    """Prints a message as the command does."""
    print_safely(message.rstrip("\n") + "\n", sys.stderr)


def in_json(value: Any) -> str:
    """As the command writes it. Numbers that are not finite are null."""

    def finite(item: Any) -> Any:
        if isinstance(item, dict):
            return {key: finite(member) for key, member in item.items()}
        if isinstance(item, (list, tuple)):
            return [finite(member) for member in item]
        return None if isinstance(item, float) and not math.isfinite(item) else item

    return json.dumps(finite(value), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


# What tells a picture of Maille from another program's, at a place from the file's end (studies/src/export/own_results.cpp).
_MARKS = {".svg": (16, b"<!-- maille -->\n"), ".png": (39, b"\0\0\0\x0ftEXtSoftware\0maille\x32\x57\x26\x53")}


def refuse_foreign(file: "str | os.PathLike[str]", overwrite: bool) -> None:
    """Refuses to replace a file that Maille did not write; its own files begin with its mark.

    Raises:
        FileExistsError: another program's file has the name, unless ``overwrite``
    """
    path = Path(file)
    if overwrite or not path.is_file() or not path.stat().st_size:
        return
    try:
        with gzip.open(path, "rb") if path.suffix == ".gz" else open(path, "rb") as stream:
            head = stream.read(160)
    except (OSError, EOFError):  # not packed
        head = b""
    has_mark = head.startswith(b"# Made by maille ") or b"\n# maille\n" in head or b"\nComment = maille\n" in head
    if head[148:155] != b"maille\0" and not has_mark:
        raise FileExistsError(f"{path}: expected a new file, or a file that Maille wrote, found another; overwrite=True replaces it")


def write_whole(file: Path, text: "str | bytes") -> None:
    """Writes a file so that it is whole or not there: a new file beside it takes its name, and its mode.

    A symbolic link stays one; the file that it leads to is replaced. Pictures get the mark of Maille's.
    """
    file = Path(os.path.realpath(file))
    data = text.encode(errors="replace") if isinstance(text, str) else text
    place, mark = _MARKS.get(file.suffix, (0, b""))
    if mark and not data[-place:].startswith(mark):
        end = len(data) - place + len(mark)
        data = data[:end] + mark + data[end:]
    if file.exists() and not file.is_file():  # a pipe or a device
        file.write_bytes(data)
        return
    # The command knows the name, and removes the file where this process is killed.
    part = file.parent / f".{file.stem}.{os.getpid()}.{os.uname().nodename.replace('.', '_')}-{secrets.token_hex(4)}.part{file.suffix}"
    mode = file.stat().st_mode & 0o777 if file.is_file() else None
    try:
        with open(part, "xb") as stream:
            stream.write(data)
        if mode is not None:
            os.chmod(part, mode)
        os.replace(part, file)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise RuntimeError(f"{file}: cannot write: {error.strerror}") from None
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def no_picture(why: str, file: "str | Path", is_kept: bool = False) -> None:
    """Says why there is none. An earlier picture of Maille's would show other results: it goes, unless it is kept."""
    complain(f"no picture: {why}")
    file = Path(file)
    place, mark = _MARKS.get(file.suffix, (0, b""))
    if mark and not is_kept and file.is_file() and not file.is_symlink() and file.read_bytes()[-place:].startswith(mark):
        file.unlink()


def deliver(text: str, file: Optional[str]) -> None:
    """Prints to standard output (None, "-"), or writes the file."""
    if file is None or file == "-":
        print_safely(text if text.endswith("\n") else text + "\n")
    else:
        write_whole(Path(file), text)


def _show_warning(message: Any, category: Any, filename: str, lineno: int, file: Any = None, line: Any = None) -> None:
    complain(f"warning: {message}")


_LEAST_MEMORY = 192 << 20  # bytes; OpenBLAS asks for a buffer of 128 MiB, and again without end where a limit refuses it


def _has_memory() -> bool:
    try:
        mmap.mmap(-1, _LEAST_MEMORY, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS).close()
        return True
    except (OSError, MemoryError):
        return False


def run_program(name: str) -> int:
    """Runs ``main(request)`` of ``maille._NAME``. @return the exit code"""
    warnings.showwarning = _show_warning
    if isinstance(sys.stdout, io.TextIOWrapper):  # names of files may be no UTF-8
        sys.stdout.reconfigure(errors="surrogateescape")
    signals: List[int] = []  # that asked to stop

    def stop(number: int, frame: Any) -> None:
        signals.append(number)
        raise KeyboardInterrupt(number)

    for one in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(one) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(one, stop)
    code = _exit_code(name, signals)
    return 128 + signals[0] if signals and code < 2 else code


def _exit_code(name: str, signals: List[int]) -> int:
    """That of ``main``, or of what it raised. @param signals  gets the one that had stopped the command before"""
    if not _has_memory():
        complain(f"out of memory: {name} needs {_LEAST_MEMORY >> 20} MiB more than the limit leaves")
        return 1
    try:
        request: Dict[str, Any] = json.load(sys.stdin)
        signals += request.pop("stopped_by", [])
        code = int(importlib.import_module(f"maille._{name}").main(request))
        _output()
        return code
    except (UsageError, SceneFaults) as error:
        complain(str(error))
        return 2
    except ModuleNotFoundError as error:
        complain(f"{name} needs the Python module {error.name}: apt install python3-{(error.name or '').split('.')[0]}")
    except ImportError as error:
        complain(f"{name} needs a Python module that cannot be used: {error}")
    except KeyboardInterrupt:
        complain("interrupted; unfinished files are removed")
    except MemoryError:
        complain("out of memory")
    except (OSError, RuntimeError, ValueError) as error:
        complain(str(error))
    return 1
