"""What the command loads: nothing heavy before it is needed, and that as soon as it is. start_test.py MAILLE SCENES

The dynamic loader itself says what it loads (LD_DEBUG=files).
"""
import pathlib
import re
import subprocess
import sys
import tempfile

MAILLE, SCENES = sys.argv[1], pathlib.Path(sys.argv[2])
FEM = re.compile(r"lib(deal\.ii|trilinos|p4est|sc-|mpi|open-rte|cholmod|umfpack|openblas|metis|petsc|slepc|tbb)")
VTK = re.compile(r"lib(vtk|GLEW|EGL|GL\.so|SDL)")


def loaded(arguments, code=0):
    """Names of all shared objects of the process and of those that it became."""
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run([MAILLE, *map(str, arguments)], capture_output=True, text=True, check=False, cwd=folder,
                             env={"LD_DEBUG": "files", "LD_DEBUG_OUTPUT": f"{folder}/loader", "PATH": "/usr/bin:/bin", "HOME": folder})
        assert run.returncode == code, f"{arguments}: exit code {run.returncode}\n{run.stdout}{run.stderr}"
        text = "".join(file.read_text(errors="replace") for file in pathlib.Path(folder).glob("loader.*"))
    names = set(re.findall(r"calling init: (\S+)", text))
    assert len(names) > 3, f"the loader said nothing of {arguments}"
    return names


def heavy(names):
    return {name for name in names if FEM.search(name) or VTK.search(name) or "/maille-" in name}


strip = SCENES / "strip_pulled.toml"
failures = []
for light in (["--version"], ["--help"], ["run", "--help"], ["help", "methods"], ["help", "study"], ["check", strip], ["check", "muscle/soleus"],
              ["check", "--why", strip], ["run", strip, "--methods", "coupled"], ["run", strip, "--methods", "limits,relaxed", "--json", "out.json"],
              ["study", "choose", strip, "--error", "99%", "--time", "1min", "--level", "50%"]):
    found = heavy(loaded(light))
    if "choose" in light:  # goes on in Python, whose numpy has a BLAS
        found = {name for name in found if "openblas" not in name}
    if found:
        failures.append(f"maille {' '.join(map(str, light))} loads {sorted(found)[:5]} and {max(0, len(found) - 5)} more")

# The same way of looking sees what is opened on demand: each plugin, and not the other.
fem = loaded(["run", strip, "--methods", "fem_q1"])
files = loaded(["run", strip, "--methods", "limits", "--out", "out"])
if not any("libdeal" in name for name in fem) or any("libvtk" in name for name in fem):  # deal.II brings OpenGL along, by gmsh
    failures.append("finite elements: expected deal.II and no VTK")
if not any(VTK.search(name) for name in files) or any(FEM.search(name) for name in files if "tbb" not in name and "mpi" not in name):
    failures.append("files: expected VTK and no deal.II")
print("\n".join(failures) or f"--version loads {len(loaded(['--version']))} shared objects, finite elements {len(fem)}, files {len(files)}")
sys.exit(1 if failures else 0)
