"""scripts/paraview/maille_compare.py in ParaView itself: methods side by side in one scale. paraview_test.py MAILLE SOURCES

Exit code 77 (skipped) without pvbatch. Debian's python3-paraview excludes what Maille builds with: unpack it and `paraview` beside
(dpkg-deb --extract) and name that folder by MAILLE_PARAVIEW. pvbatch draws on an X server: that of DISPLAY, else xvfb-run's.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

MAILLE, SOURCES = sys.argv[1], pathlib.Path(sys.argv[2])
environment = dict(os.environ)
pvbatch = shutil.which("pvbatch")
if unpacked := os.environ.get("MAILLE_PARAVIEW"):
    root = pathlib.Path(unpacked) / "usr"
    pvbatch = str(next(iter(root.glob("bin/pvbatch*")), "")) or None
    environment |= {"LD_LIBRARY_PATH": f"{root}/lib/x86_64-linux-gnu", "PYTHONPATH": f"{root}/lib/python3/dist-packages"}
if not pvbatch or not (os.environ.get("DISPLAY") or shutil.which("xvfb-run")):
    print("there is no pvbatch, or no X server for it: set MAILLE_PARAVIEW to where ParaView is unpacked")
    sys.exit(77)
# A server that starts anew after its first client would be gone when the second comes.
server = [] if os.environ.get("DISPLAY") else ["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24 -noreset"]

SCENE = """[specimen]
shape = "box"
cells = [16, 4, 4]
spacing = "2 mm"
material = "muscle/vastus_lateralis"
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = ["2 mm", 0, 0]
"""


def check(truth, words):
    if not truth:
        raise SystemExit(words)


def grey_levels(png):
    """How many different bytes the picture's data have, unpacked: one that is blank has few."""
    import struct
    import zlib
    data, at, packed = png.read_bytes(), 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        packed += data[at + 8:at + 8 + length] if kind == b"IDAT" else b""
        at += 12 + length
    return len(set(zlib.decompress(packed)))


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    (folder / "strip.toml").write_text(SCENE, encoding="utf-8")
    methods = ["limits", "coupled", "fem_q1"]
    subprocess.run([MAILLE, "compare", "strip.toml", "--methods", ",".join(methods), "--out", "out"], cwd=folder, check=True, capture_output=True)
    words = [*server, "env", *(f"{key}={environment[key]}" for key in ("LD_LIBRARY_PATH", "PYTHONPATH") if key in environment),
             pvbatch, str(SOURCES / "scripts/paraview/maille_compare.py"), "out/strip.vtm", "--png", "side.png", "--state", "side.pvsm"]
    run = subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)
    check(run.returncode == 0, run.stdout + run.stderr)
    bounds = {found.group(1): [float(n) for n in found.group(2).split()] for found in re.finditer(r"^(\w+): (\S+(?: \S+){5})$", run.stdout, re.M)}
    check(list(bounds) == methods, f"expected the methods in their order:\n{run.stdout}")
    for method, b in bounds.items():  # 32 mm, drawn out by 2; 8 mm across
        check(abs(b[0]) < 1e-9 and abs(b[1] - 0.034) < 1e-6 and abs(b[5] - b[4] - 0.008) < 5e-4, f"{method} is not the deformed strip: {b}")
    for above, below in zip(methods, methods[1:]):
        check(bounds[below][3] < bounds[above][2], f"{above} and {below} overlap: {bounds}")
    check("largest Displacement: 0.002\n" in run.stdout, run.stdout)  # what is moved by 2 mm moves most
    check(grey_levels(folder / "side.png") > 100, "the picture is blank")
    state = (folder / "side.pvsm").read_text(encoding="utf-8")
    check(all(f'"{method}"' in state for method in methods) and "strip.vtm" in state, "the state does not name the methods")
    print("side by side:", ", ".join(bounds))
