"""The program that ``maille study``, ``study merge --study``, ``study trade`` and ``study choose`` become once they have measured."""

from __future__ import annotations

import importlib
from typing import Any, Dict

_MODULES = {"study": "_study", "merge": "_study", "trade": "_trade", "choose": "_choose", "tables": "_choose"}


def main(request: Dict[str, Any]) -> int:
    return int(importlib.import_module(f"maille.{_MODULES[request['kind']]}").finish(request))
