"""scripts/house finds what it is there to find: in a tree made for it, of two rooms in the wrong order."""
import pathlib
import subprocess
import sys
import tempfile

HOUSE = pathlib.Path(__file__).resolve().parents[2] / "scripts" / "house"


def write(root, name, text):
    path = root / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def arrows(upper_level_first, extra=""):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        write(root, "scripts/house", HOUSE.read_text(encoding="utf-8"))
        write(root, "deform/src/low/a.hpp", "#pragma once\n")
        write(root, "deform/src/high/b.cpp", '#include "low/a.hpp"\n' + extra)
        order = '[["high"], ["low"]]' if upper_level_first else '[["low"], ["high"]]'
        write(root, "tests/architecture/rooms.toml", f"deform = {order}\n")
        for command in (["git", "init", "-q"], ["git", "add", "-A"]):
            subprocess.run(command, cwd=root, check=True)
        run = subprocess.run([sys.executable, root / "scripts/house", "--arrows"], capture_output=True, text=True, check=False)
        return run.returncode, run.stdout


code, text = arrows(upper_level_first=False)
assert code == 0, text
code, text = arrows(upper_level_first=True)
assert code == 1 and "deform/high includes deform/low" in text, text
print("found")
