"""Programs that continue the command, in Python.

The command `maille` checks its options, then becomes the program `maille-NAME`. That program reads one JSON
object from standard input, and calls ``main(request)`` of the module ``maille._NAME``, which returns the exit
code. The function that does the work is public (``maille.report``), so that the command and a notebook share it.

Exit codes are the command's: 0 done, 1 the run failed, 2 faulty input.
"""

from __future__ import annotations

import importlib
import json
import os
import sys
import tempfile
import warnings
from pathlib import Path
from typing import Any, Dict, Optional

from ._faults import SceneFaults


class UsageError(ValueError):
    """The request or a file of the user is faulty: one line, exit code 2."""


def complain(message: str) -> None:
    """Prints a message as the command does. Control characters of names and files do not reach the terminal."""
    for line in message.splitlines() or [""]:
        print("".join(c if c.isprintable() or c == "\t" else "?" for c in line), file=sys.stderr)


def write_whole(file: Path, text: "str | bytes") -> None:
    """Writes a file so that it is whole or not there: a new file beside it takes its name."""
    handle, name = tempfile.mkstemp(prefix="." + file.name + ".", dir=file.parent)
    try:
        with os.fdopen(handle, "wb") as stream:
            stream.write(text.encode() if isinstance(text, str) else text)
        umask = os.umask(0)
        os.umask(umask)
        os.chmod(name, 0o666 & ~umask)
        os.replace(name, file)
    except BaseException:
        os.unlink(name)
        raise


def deliver(text: str, file: Optional[str]) -> None:
    """Prints to standard output (None, "-"), or writes the file."""
    if file is None or file == "-":
        sys.stdout.write(text if text.endswith("\n") else text + "\n")
    else:
        write_whole(Path(file), text)


def _show_warning(message: Any, category: Any, filename: str, lineno: int, file: Any = None, line: Any = None) -> None:
    complain(f"warning: {message}")


def run_program(name: str) -> int:
    """Runs ``main(request)`` of ``maille._NAME``. @return the exit code"""
    warnings.showwarning = _show_warning
    try:
        request: Dict[str, Any] = json.load(sys.stdin)
        code = int(importlib.import_module(f"maille._{name}").main(request))
        sys.stdout.flush()
        return code
    except (UsageError, SceneFaults) as error:
        complain(str(error))
        return 2
    except ModuleNotFoundError as error:
        complain(f"{name} needs the Python module {error.name}: apt install python3-{(error.name or '').split('.')[0]}")
    except KeyboardInterrupt:
        complain("interrupted; unfinished files are removed")
    except BrokenPipeError:
        sys.stdout = None  # type: ignore[assignment]
        complain("cannot write to standard output")
    except MemoryError:
        complain("out of memory")
    except (OSError, RuntimeError, ValueError) as error:
        complain(str(error))
    return 1
