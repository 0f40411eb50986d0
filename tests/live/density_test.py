"""Letters are as large as a desktop asks for: `Xft.dpi` of the X server's resources, here of ~/.Xdefaults.

Usage: density_test.py MAILLE SCENES    (under xvfb-run; see CMakeLists.txt)
"""
import json
import os
import subprocess
import sys
import tempfile

MAILLE, SCENES = sys.argv[1:3]


def text_scale(home, dots):
    with open(os.path.join(home, ".Xdefaults"), "w") as file:
        file.write(f"Xft.dpi: {dots}\n" if dots else "")
    script = os.path.join(home, "close.csv")
    with open(script, "w") as file:
        file.write("time [s],event,x,y,button,name,value\n0.1,close,,,,,\n")
    run = subprocess.run([MAILLE, "live", os.path.join(SCENES, "world", "maze.toml"), "--script", script, "--json"], check=True,
                         capture_output=True, text=True, timeout=60, env={**os.environ, "HOME": home})
    return json.loads(run.stdout)["text_scale"]


with tempfile.TemporaryDirectory() as home:
    for dots, expected in ((0, 1), (96, 1), (144, 1.5), (192, 2), (1000, 3)):
        found = text_scale(home, dots)
        if found != expected:
            sys.exit(f"Xft.dpi {dots}: expected letters {expected} times as large, found {found}")
