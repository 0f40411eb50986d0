"""Every program and plugin is hardened, and the loader looks in no relative folder: hardening_test.py FILE...

Read from the files by readelf: RUNPATH, full RELRO, position independence, an unexecutable stack; from their symbols: the stack protector and
the checked calls of libc; from their code: landing pads of control-flow enforcement (x86 alone).
"""
import os
import platform
import re
import subprocess
import sys
import tempfile


def output(*command):
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def relative_paths(file):
    """Entries of RPATH and RUNPATH that depend on the current folder; an empty one is the current folder."""
    entries = [entry for found in re.findall(r"\(R(?:UN)?PATH\).*\[(.*)\]", output("readelf", "-dW", file)) for entry in found.split(":")]
    return [entry for entry in entries if not entry.startswith(("/", "$ORIGIN"))]


def missing(file):
    dynamic, segments, symbols = output("readelf", "-dW", file), output("readelf", "-lW", file), output("readelf", "--dyn-syms", "-W", file)
    wanted = {
        "BIND_NOW": "BIND_NOW" in dynamic or re.search(r"FLAGS_1.*NOW", dynamic),
        "RELRO": "GNU_RELRO" in segments,
        "no executable stack": re.search(r"GNU_STACK.* RW ", segments),
        "position independence": "DYN" in output("readelf", "-hW", file),
        "stack protector": "__stack_chk_fail" in symbols,
        # Where it is on, libc's functions of formatting and copying strings are checked ones; std::to_string takes the address of vsnprintf.
        "_FORTIFY_SOURCE": not re.search(r" (v?sprintf|snprintf|v?f?printf|strcpy|strcat)@", symbols),
    }
    if platform.machine() == "x86_64":
        wanted["CET"] = b"\xf3\x0f\x1e\xfa" in open(file, "rb").read()
    return [name for name, found in wanted.items() if not found]


failures, paths = [], 0
for file in sys.argv[1:]:
    relative = relative_paths(file)
    paths += len(relative)
    failures += [f"{file}: relative entries {relative} in its RUNPATH"] if relative else []
    failures += [f"{file}: without {', '.join(missing(file))}"] if missing(file) else []

# A library in the current folder is not loaded: a file that only has zlib's name changes nothing.
with tempfile.TemporaryDirectory() as folder:
    with open(os.path.join(folder, "libz.so.1"), "w", encoding="ascii") as planted:
        planted.write("no library")
    failures += [] if subprocess.run([os.path.abspath(sys.argv[1]), "--version"], cwd=folder, capture_output=True, check=False).returncode == 0 else ["a planted library is read"]
print("\n".join(failures) or f"{len(sys.argv) - 1} files")
print(f"loader_paths_relative {paths}")
sys.exit(1 if failures else 0)
