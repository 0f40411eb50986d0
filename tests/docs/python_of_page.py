"""Runs every Python snippet of one page, in the order of the page, as one program: python_of_page.py SOURCES PAGE

In a folder with what such a page speaks of: labels.nii.gz (a block of label 17), scan.nii.gz, strip.toml, world.toml, world_path.toml, and the folder of `maille new calf`. The module
is looked for in MAILLE_PYTHON_PATH. Snippets that need a package which is not there are skipped, and it says so.
"""
import importlib.util
import os
import pathlib
import re
import subprocess
import sys
import tempfile

from commands_of_page import print_figure

sys.path.insert(0, os.environ["MAILLE_PYTHON_PATH"])

STRIP = """
[specimen]
shape = "box"
cells = [8, 4, 4]
spacing = "1 mm"
material = "muscle/soleus"
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = ["0.4 mm", 0, 0]
"""


def text_of_new(sources, name):
    """A text that `maille new` writes."""
    return (sources / "studies/src/cli/texts" / name).read_text(encoding="utf-8")


def prepare(folder, sources):
    import nibabel
    import numpy

    labels = numpy.zeros((10, 10, 16), dtype=numpy.int16)
    labels[2:8, 2:8, 2:14] = 17
    affine = numpy.diag([2.0, 2, 4, 1])
    nibabel.save(nibabel.Nifti1Image(labels, affine), folder / "labels.nii.gz")
    nibabel.save(nibabel.Nifti1Image(labels.astype(numpy.float32) * 3, affine), folder / "scan.nii.gz")
    (folder / "strip.toml").write_text(STRIP)
    (folder / "world.toml").write_text(text_of_new(sources, "world.toml"))
    (folder / "world_path.toml").write_text(text_of_new(sources, "path.toml"))
    command = pathlib.Path(os.environ["MAILLE_PYTHON_PATH"]).parent / "maille"
    if command.exists():
        subprocess.run([command, "new", "calf"], cwd=folder, check=True, stdout=subprocess.DEVNULL)


def main():
    sources, name = pathlib.Path(sys.argv[1]), sys.argv[2]
    page = (sources / name).read_text(encoding="utf-8")
    snippets = re.findall(r"^```python\n(.*?)^```", page, re.S | re.M)
    needed = set(re.findall(r"^\s*(?:import|from) (\w+)|, (\w+) as", "\n".join(snippets), re.M))
    for package in ("nibabel", *(word for pair in needed for word in pair if word)):
        if package != "maille" and importlib.util.find_spec(package) is None:
            print(f"{name}: skipped, python3-{package} is not installed")
            return 0
    with tempfile.TemporaryDirectory(prefix="maille-python-") as temporary:
        folder = pathlib.Path(temporary)
        prepare(folder, sources)
        (folder / "page.py").write_text("\n".join(snippets), encoding="utf-8")
        run = subprocess.run([sys.executable, "page.py"], cwd=folder, capture_output=True, text=True,
                             env={**os.environ, "PYTHONPATH": os.environ["MAILLE_PYTHON_PATH"], "MPLCONFIGDIR": temporary, "MPLBACKEND": "Agg"})
    print(f"{name}: {len(snippets)} snippets, exit {run.returncode}\n{run.stderr}")
    print_figure(int(run.returncode != 0))
    return 1 if run.returncode or not snippets else 0


if __name__ == "__main__":
    sys.exit(main())
