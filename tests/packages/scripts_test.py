"""scripts/install-dependencies against a Debian that is only played: what it installs for which purpose, and that it takes nothing away.

scripts_test.py SOURCES
"""
import os
import pathlib
import subprocess
import sys
import tempfile

SCRIPT = pathlib.Path(sys.argv[1]) / "scripts/install-dependencies"
PLAYED = {
    "dpkg-query": '#!/bin/sh\nfor word; do last=$word; done\ngrep -qx "$last" "$PLAY/installed" && printf "install ok installed"\n',
    "apt-get": '#!/bin/sh\necho "apt-get $*" >> "$PLAY/log"\ncase "$*" in *--simulate*) cat "$PLAY/simulated" ;; esac\n',
    "id": "#!/bin/sh\necho 0\n",
}
failures = []


def play(words, installed=(), simulated=""):
    """Exit code, what it says, and what it asks apt-get to do."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for program, text in PLAYED.items():
            (folder / program).write_text(text, encoding="utf-8")
            (folder / program).chmod(0o755)
        (folder / "installed").write_text("\n".join(installed) + "\n", encoding="utf-8")
        (folder / "simulated").write_text(simulated, encoding="utf-8")
        (folder / "log").touch()
        run = subprocess.run([SCRIPT, *words], capture_output=True, text=True, check=False,
                             env={"PATH": f"{folder}:{os.environ['PATH']}", "PLAY": str(folder)})
        return run.returncode, run.stdout + run.stderr, (folder / "log").read_text(encoding="utf-8").splitlines()


def expect(truth, words):
    if not truth:
        failures.append(words)


lists = {purpose: set(play([purpose, "--list"])[1].split()) for purpose in ("run", "test", "bench")}
expect(lists["run"] < lists["test"] < lists["bench"], "a purpose has the packages of those before it, and more")
expect({"libgtest-dev", "valgrind", "clang", "libbullet-dev", "calculix-ccx"}.isdisjoint(lists["run"]), "running needs no package of tests and benchmarks")
expect({"clang", "libbullet-dev", "calculix-ccx"}.isdisjoint(lists["test"]), "tests need no package of benchmarks and fuzzers")
expect({"libdeal.ii-dev", "libvtk9-dev"} <= lists["run"], "the command is built with deal.II and VTK")

code, said, log = play(["run"], installed=lists["run"])
expect(code == 0 and not log, f"nothing is to be done where all is installed: {code} {log}")

code, said, log = play(["run"], installed=lists["run"] - {"libfmt-dev"})
installs = [line for line in log if " install " in line and "--simulate" not in line]
expect(code == 0 and len(installs) == 1 and installs[0].endswith(" libfmt-dev") and "--no-remove" in installs[0], f"one package alone: {log}")

code, said, log = play(["run"], installed=(lists["run"] - {"libvtk9-dev"}) | {"python3-paraview"})
expect(code == 3 and "python3-paraview" in said and "exclude each other" in said and not log, f"python3-paraview stays: {code} {said} {log}")

code, said, log = play(["run"], installed=lists["run"] - {"libfmt-dev"}, simulated="Remv user-package [1.0]\nInst libfmt-dev\n")
expect(code == 3 and "user-package" in said and all("--simulate" in line for line in log if " install " in line), f"nothing is taken away: {code} {said} {log}")

code, said, log = play(["all"])
expect(code == 2 and '"all"' in said and not log, f"an unknown purpose: {code} {said}")
print("\n".join(failures) or f"packages to run {len(lists['run'])}, to test {len(lists['test'])}, to measure {len(lists['bench'])}")
sys.exit(1 if failures else 0)
