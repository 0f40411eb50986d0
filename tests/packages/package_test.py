"""The Debian packages of a build: made, unpacked into a root of their own, and run from there. package_test.py BUILD SOURCES

The root holds nothing but what the packages bring; shared libraries are the machine's, and the packages' Depends must name every Debian package
that any of them comes from. Exit code 77 (skipped) where the machine cannot make packages.
"""
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

BUILD, SOURCES = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])
if not all(shutil.which(program) for program in ("cpack", "dpkg-deb", "dpkg-shlibdeps")):
    print("cpack, dpkg-deb or dpkg-shlibdeps is missing")
    sys.exit(77)


def run(words, code=0, **rest):
    done = subprocess.run(list(map(str, words)), capture_output=True, text=True, check=False, **rest)
    if done.returncode != code:
        raise SystemExit(f"{' '.join(map(str, words))}: expected exit code {code}, found {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def check(truth, words):
    if not truth:
        raise SystemExit(words)


def field(package, name):
    return run(["dpkg-deb", "--field", package, name]).strip()


def dependencies(package):
    """Names in Depends, every alternative."""
    return set(re.findall(r"[a-z0-9][a-z0-9.+-]+(?=[ ,|(]|$)", re.sub(r"\([^)]*\)", "", field(package, "Depends"))))


def needed_packages(files):
    """The Debian packages of what shared objects are linked to, as the loader resolves it."""
    paths = set()
    for file in files:
        for line in run(["readelf", "-d", file]).splitlines():
            if found := re.search(r"\(NEEDED\).*\[(.*)\]", line):
                paths.add(found.group(1))
    resolved = {match.group(1): match.group(2) for file in files for match in re.finditer(r"(\S+) => (/\S+)", run(["ldd", file]))}
    owners = set()
    for name in paths:
        path = os.path.realpath(resolved[name]) if name in resolved else None
        if path:
            # Of what stood in /lib before that became a link to /usr/lib, dpkg still knows the old name.
            known = subprocess.run(["dpkg", "-S", path], capture_output=True, check=False).returncode == 0
            owner = run(["dpkg", "-S", path if known else path.removeprefix("/usr")]) if pathlib.Path(path).exists() else ""
            owners.add(owner.split(":")[0])
    return owners


with tempfile.TemporaryDirectory(dir=BUILD) as name:
    folder = pathlib.Path(name)
    run(["cpack", "--config", BUILD / "CPackConfig.cmake", "-B", folder])
    packages = {field(file, "Package"): file for file in folder.glob("*.deb")}
    check({"maille", "libmaille-dev"} <= packages.keys(), f"expected maille and libmaille-dev, found {sorted(packages)}")
    root = folder / "root"
    for file in packages.values():
        check("@" in field(file, "Maintainer") and field(file, "Architecture") == run(["dpkg", "--print-architecture"]).strip(), f"{file}: control")
        run(["dpkg-deb", "--extract", file, root])

    maille, plugins = root / "usr/bin/maille", root / "usr/lib/maille"
    objects = [maille, *(file for file in plugins.iterdir() if file.read_bytes().startswith(b"\x7fELF"))]
    missing = needed_packages(objects) - dependencies(packages["maille"]) - {"libgcc-s1", "libc6"}
    check(not missing, f"the package maille does not depend on {sorted(missing)}")
    check({"libdeal.ii-9.4.1", "libvtk9.1"} <= dependencies(packages["maille"]), "expected deal.II and VTK in Depends of maille")

    # docs/licences.md has a row for each object with its packages; those with a GPL have a stanza in the package's copyright file.
    rows = re.findall(r"^\| (`.*?) \| (.*?) \| (.*?) \|$", (SOURCES / "docs/licences.md").read_text(encoding="utf-8"), re.M)
    copyright = (root / "usr/share/doc/maille/copyright").read_text(encoding="utf-8")
    for file in objects:
        named, licence = [(libraries, licence) for files, libraries, licence in rows if f"`{file.name}`" in files][0]
        missing = {package for package in needed_packages([file]) - {"libgcc-s1", "libc6", "libstdc++6", ""} if package not in re.findall(r"[\w.+-]+", named)}
        check(not missing, f"docs/licences.md: the row of {file.name} does not name {sorted(missing)}")
        gpl = bool({"libcholmod3", "libdeal.ii-9.4.1"} & needed_packages([file]))
        check(gpl == ("GPL" in licence) == (file.name in copyright and licence in copyright), f"{file.name}: licence {licence}")
    runpaths = [line for file in objects for line in run(["readelf", "-d", file]).splitlines() if "RUNPATH" in line or "RPATH" in line]
    check(all("[$ORIGIN" in line for line in runpaths), f"a path of the build tree is in {runpaths}")

    # Where the build tree is out of reach of everything but what was unpacked: paths are relative to the program.
    work = folder / "work"
    work.mkdir()
    clean = {"PATH": f"{root}/usr/bin:/usr/bin:/bin", "HOME": str(work)}
    scene = root / "usr/share/maille/scenes/strip_pulled.toml"
    check(run(["maille", "--version"], env=clean, cwd=work).startswith("maille "), "expected a version")
    found = run(["maille", "compare", scene, "--methods", "coupled,fem_q1", "--out", "out"], env=clean, cwd=work)
    check(re.search(r"fem_q1 +done", found) and (work / "out/strip_pulled.vtm").is_file(), found)
    run(["maille", "report", "out"], env=clean, cwd=work)
    check((work / "out/report.html").is_file(), "expected a report")

    # A part that is not there is named, with where it was looked for, and the rest works.
    for part, words in (("maille-fem.so", ["run", scene, "--methods", "fem_q1"]), ("maille-vtk.so", ["run", scene, "--out", "out2"]),
                        ("maille-report", ["report", "out"])):
        (plugins / part).rename(folder / part)
        said = run(["maille", *words], code=1, env=clean, cwd=work)
        check(part in said and str(plugins.resolve()) in str(pathlib.Path(said)).replace(f"{root}/usr/bin/../lib", str(plugins.parent)), said)
        run(["maille", "run", scene, "--methods", "coupled"], env=clean, cwd=work)
        (folder / part).rename(plugins / part)

    # A program is built against what libmaille-dev brings.
    if "--no-consumer" not in sys.argv:
        consumer = SOURCES / "tests/architecture/consumer"
        run(["cmake", "-S", consumer, "-B", folder / "consumer", f"-DCMAKE_PREFIX_PATH={root}/usr", "-DCMAKE_BUILD_TYPE=Release"])
        run(["cmake", "--build", folder / "consumer", "--target", "from_text"])
        check(run([folder / "consumer/from_text"]) == "coupled: done, 1.000 mm\n", "the consumer's answer")

    # The Python module, where it was built, by its own path alone; it opens neither deal.II nor VTK.
    if "python3-maille" in packages:
        code = (f"import maille; print(maille.Scene.from_file('{scene}').run('coupled').status, "
                "any(name in open('/proc/self/maps').read() for name in ('libdeal', 'libvtk')))")
        said = run(["/usr/bin/python3", "-c", code], env=clean | {"PYTHONPATH": f"{root}/usr/lib/python3/dist-packages"}, cwd=work)
        check(said.split() == ["done", "False"], said)

    pages_of_help = re.findall(r"^ *More: +(docs/\S+?\.md)", run(["maille", "help", "compare"], env=clean, cwd=work), re.M)
    check(pages_of_help and all((root / "usr/share/doc/maille" / page).is_file() for page in [*pages_of_help, "docs/glossary.md"]), f"{pages_of_help}")

    # Pages of the manual and completions, made from the command's own help.
    pages = sorted((root / "usr/share/man/man1").iterdir())
    commands = re.findall(r"^  (\w+) ", run(["maille", "--help"], env=clean, cwd=work).split("Model:")[1], re.M)
    check({page.name for page in pages} == {"maille.1", *(f"maille-{command}.1" for command in [*commands, "study-trade", "study-choose", "study-merge"])}, f"pages: {pages}")
    options = set(re.findall(r"^  (?:-\w,)?(--[\w-]+)", run(["maille", "compare", "--help"], env=clean, cwd=work), re.M))
    text = (root / "usr/share/man/man1/maille-compare.1").read_text(encoding="utf-8").replace("\\-", "-")
    check(len(options) > 8 and all(option in text for option in options), f"options that the page lacks: {[o for o in options if o not in text]}")
    if shutil.which("mandoc"):
        for page in pages:
            said = run(["mandoc", "-T", "lint", "-W", "error", page])
            check(not said, said)

    def completed(words):
        script = root / "usr/share/bash-completion/completions/maille"
        line = " ".join(f"'{word}'" for word in words)
        return set(run(["bash", "-c", f"source {script}; COMP_WORDS=({line}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _maille; "
                        "printf '%s\\n' \"${COMPREPLY[@]}\""]).split())

    check(completed(["maille", ""]) >= {*commands, "--version"}, f"commands: {completed(['maille', ''])}")
    check(completed(["maille", "compare", "--"]) >= options, "options of compare")
    check(completed(["maille", "compare", "--picture-of", ""]) == {"displacement", "strain", "stress", "error"}, "choices of --picture-of")
    check(completed(["maille", "run", "--methods", "limits,cou"]) == {"limits,coupled"}, f"{completed(['maille', 'run', '--methods', 'limits,cou'])}")
    check(completed(["maille", "run", "--also", "mha,n"]) == {"mha,nrrd"}, "formats in a list")
    check(completed(["maille", "help", "meth"]) == {"methods"} and "--spacings" in completed(["maille", "study", "trade", "--"]), "topics, and two words")
    if shutil.which("zsh"):
        run(["zsh", "-n", root / "usr/share/zsh/vendor-completions/_maille"])
    print(f"{', '.join(sorted(packages))}: {len(objects)} programs and plugins, {len(pages)} pages")
