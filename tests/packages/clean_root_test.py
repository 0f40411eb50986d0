"""The Debian packages of a build, installed by apt into a Debian that holds nothing else, and run there. clean_root_test.py BUILD

Exit code 77 (skipped) unless MAILLE_CLEAN_ROOT is set: it takes minutes, 3 GB and a mirror. What it names is a mirror, as debootstrap takes
it, or a folder with such a Debian that is copied. Wants root, debootstrap, chroot and unshare.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

BUILD, BASE = pathlib.Path(sys.argv[1]), os.environ.get("MAILLE_CLEAN_ROOT")
if not BASE:
    print("skipped: MAILLE_CLEAN_ROOT is not set")
    sys.exit(77)
if os.geteuid() != 0 or not all(shutil.which(program) for program in ("debootstrap", "chroot", "unshare", "cpack")):
    print("skipped: a clean root wants root's rights, debootstrap, chroot, unshare and cpack")
    sys.exit(77)


def run(words, **rest):
    done = subprocess.run(list(map(str, words)), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **rest)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(map(str, words))}: exit code {done.returncode}\n{done.stdout[-3000:]}")
    return done.stdout


with tempfile.TemporaryDirectory() as name:
    folder = pathlib.Path(name)
    root = folder / "root"
    if pathlib.Path(BASE).is_dir():
        run(["cp", "-a", BASE, root])
    else:
        run(["debootstrap", "--variant=minbase", "bookworm", root, BASE])
    run(["cpack", "--config", BUILD / "CPackConfig.cmake", "-B", root / "packages"])
    packages = sorted(file.name for file in (root / "packages").glob("*.deb"))
    shutil.copy("/etc/resolv.conf", root / "etc/resolv.conf")
    environment = {"DEBIAN_FRONTEND": "noninteractive", "PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/root", "LC_ALL": "C.UTF-8"}

    def inside(*words):
        # With /proc, from which programs know where they are; it goes with the namespace.
        return run(["unshare", "--mount", "sh", "-c", 'mount -t proc proc "$0/proc" && exec chroot "$0" "$@"', root, *words],
                   env=environment)

    inside("apt-get", "update", "-q")
    wanted = [f"/packages/{file}" for file in packages if not file.startswith("libmaille-dev")]
    inside("apt-get", "install", "-y", "-q", "--no-install-recommends", *wanted, "python3-jinja2", "python3-matplotlib")
    scene = "/usr/share/maille/scenes/strip_pulled.toml"
    if not inside("maille", "--version").startswith("maille "):
        raise SystemExit("expected a version")
    said = inside("maille", "compare", scene, "--methods", "coupled,fem_q1", "--out", "/tmp/out")
    if not re.search(r"fem_q1 +done", said):
        raise SystemExit(said)
    inside("maille", "report", "/tmp/out")
    if not (root / "tmp/out/report.html").is_file():
        raise SystemExit("expected a report")
    if any(file.startswith("python3-maille") for file in packages):
        code = f"import maille; a = maille.Scene.from_file('{scene}').run('coupled'); print(a.status)"
        if "done" not in inside("python3", "-c", code):
            raise SystemExit("expected an answer from Python")
    print(f"a clean Debian with {', '.join(wanted)} answers by coupled and fem_q1, and writes a report")
