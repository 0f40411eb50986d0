"""Scenes as plain values and as text: the part of TOML that scene files need."""

from __future__ import annotations

import json
import re
from typing import Any, Mapping

import numpy as np

_BARE = re.compile(r"[A-Za-z0-9_-]+\Z")


def _key(key: object) -> str:
    text = str(key)
    return text if _BARE.match(text) else json.dumps(text, ensure_ascii=False)


def plain(item: Any) -> Any:
    """Truths, numbers, texts, lists and tables alone: arrays as lists, without keys that have no value."""
    if isinstance(item, (np.ndarray, np.generic)):
        item = item.tolist()
    if isinstance(item, str) and item.encode(errors="replace") != item.encode(errors="surrogatepass"):
        raise ValueError(f"expected a text in UTF-8, found {item!r}")
    if isinstance(item, (bool, str)):
        return item
    if isinstance(item, (int, float)):
        return int(item) if isinstance(item, int) and -2**63 <= item < 2**63 else float(item)
    if isinstance(item, Mapping):
        return {str(key): plain(one) for key, one in item.items() if one is not None}
    try:
        return [plain(part) for part in item]
    except TypeError:
        raise TypeError(f"expected a number, a text, a list or a table of such, found {item!r}") from None


def value(item: Any) -> str:
    """One plain value; a mapping as an inline table."""
    item = plain(item)
    if isinstance(item, bool):
        return "true" if item else "false"
    if isinstance(item, (int, float)):
        return repr(item)
    if isinstance(item, str):
        return json.dumps(item, ensure_ascii=False)
    if isinstance(item, dict):
        return "{ " + ", ".join(f"{_key(k)} = {value(v)}" for k, v in item.items()) + " }"
    return "[" + ", ".join(value(part) for part in item) + "]"


def _is_tables(item: Any) -> bool:
    return isinstance(item, (list, tuple)) and len(item) > 0 and all(isinstance(part, Mapping) for part in item)


def dumps(document: Mapping[str, Any]) -> str:
    """A scene's text: what is plain first, then its tables, then its lists of tables, as ``[[hold]]``."""
    plain, tables, lists = [], [], []
    for key, item in document.items():
        if item is None:
            continue
        if isinstance(item, Mapping):
            lines = [f"{_key(k)} = {value(v)}" for k, v in item.items() if v is not None]
            tables.append("\n".join([f"[{_key(key)}]", *lines]))
        elif _is_tables(item):
            for part in item:
                lines = [f"{_key(k)} = {value(v)}" for k, v in part.items() if v is not None]
                lists.append("\n".join([f"[[{_key(key)}]]", *lines]))
        else:
            plain.append(f"{_key(key)} = {value(item)}")
    return "\n\n".join([part for part in ("\n".join(plain), *tables, *lists) if part]) + "\n"
