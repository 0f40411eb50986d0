"""Every word of the tables that the command prints is explained: words_of_output.py MAILLE SOURCES

Headings of tables and names of parts of a model are looked up in the tables of docs/glossary.md, in the section of the command that printed them. A
line of headings must consist of such words and nothing else.
"""
import pathlib
import re
import subprocess
import sys
import tempfile

# The one measure of the scene that `maille new strip` writes: a name of the user's.
OF_THE_SCENE = {"pull"}
STUDY = """scene = "strip.toml"
methods = ["limits", "coupled"]
reference = "fem_q1"
[[parameter]]
key = "move.0.by.0"
values = ["1 mm", "2 mm"]
"""
BAR = """[specimen]
shape = "box"
cells = [8, 4, 4]
spacing = "1 mm"
material = { youngs_modulus = "10 kPa", poisson_ratio = 0.3 }
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = ["0.4 mm", 0, 0]
[[measure]]
name = "pull"
force = "move[1]"
"""


def sections(page):
    """Command -> words that the glossary explains in its section."""
    text = page.read_text(encoding="utf-8").split("## What the command prints")[1].split("\n## ")[0]
    found, commands = {}, []
    for line in text.split("\n"):
        if line.startswith("**"):
            commands = re.findall(r"`(\w+)[ \w-]*`", line)
        elif line.startswith("| ") and not line.startswith(("| ---", "| word")):
            words = re.sub(r"\\\|", "/", line).split("|")[1]
            for command in commands:
                found.setdefault(command, set()).update(word.strip().lower() for word in words.split(","))
    return found


def unexplained(heading, words):
    """What is left of a line of headings once every word that is explained is taken out, longest first."""
    left = " " + re.sub(r"\s+", "  ", heading.lower()) + " "
    for word in sorted(words, key=len, reverse=True):
        left = left.replace(f" {word.replace(' ', '  ')} ", "  ")
    return left.split()


def headings(command, output):
    lines = output.split("\n")
    for above, below in zip(lines, lines[1:]):
        if re.match(r"\s*(method|part|step|label|is|array|measure|unknown|L2 error|material \(axis 1 = fibre\))\s", above) and (below.strip() or command == "check"):
            yield above


def parts_of_the_model(output):
    lines = output.split("\n")
    begin = next(n for n, line in enumerate(lines) if line.startswith("is ")) + 1
    width = lines[begin - 1].index("why")
    for line in lines[begin:]:
        if not line.strip():
            return
        yield line[3:width].strip()


def main():
    maille, sources = sys.argv[1], pathlib.Path(sys.argv[2])
    explained, faults, n_looked_up = sections(sources / "docs/glossary.md"), [], 0
    scenes = sources / "scene/scenes"
    with tempfile.TemporaryDirectory(prefix="maille-words-") as folder:
        made = subprocess.run([maille, "new", "strip", "--out", f"{folder}/strip.toml"], capture_output=True, text=True)
        if made.returncode != 0:
            print(made.stderr)
            return 1
        labels(pathlib.Path(folder) / "labels.mha")
        subprocess.run([maille, "new", "image", f"{folder}/labels.mha", "--out", f"{folder}/labels.toml"], check=True, capture_output=True)
        (pathlib.Path(folder) / "study.toml").write_text(STUDY)
        (pathlib.Path(folder) / "bar.toml").write_text(BAR)
        (pathlib.Path(folder) / "bar.csv").write_text("measure,value,sigma\npull_x,0.04 N,1 mN\n")
        for words in (["run", f"{folder}/strip.toml", "--methods", "limits,coupled", "--steps", "2", "--estimate"], ["compare", f"{folder}/strip.toml"],
                      ["check", f"{folder}/labels.toml"], ["check", "--why", f"{folder}/labels.toml"], ["run", f"{folder}/labels.toml"],
                      ["new", "image", f"{folder}/labels.mha", "--out", f"{folder}/again.toml"], ["check", "library"],
                      ["study", f"{folder}/study.toml", "--out", f"{folder}/study"],
                      ["study", "trade", f"{folder}/strip.toml", "--methods", "limits,coupled", "--spacings", "2", "--reference", "fem_q1", "--repetitions", "1"],
                      ["fit", f"{folder}/bar.toml", "--measured", f"{folder}/bar.csv", "--unknown", "specimen.material.youngs_modulus"],
                      ["fit", f"{folder}/strip.toml", "--trials", "20", "--reference", "fem_q1"],
                      ["check", "--why", str(scenes / "elbow.toml")], ["check", "--why", str(scenes / "bar_bent.toml")], ["run", f"{folder}/labels.toml", "--warp", "--out", f"{folder}/out"]):
            run = subprocess.run([maille, *words], capture_output=True, text=True)
            if run.returncode != 0 and words[0] != "fit":  # which has ended at its budget
                faults.append(f"{' '.join(words)}: exit {run.returncode}\n{run.stdout}{run.stderr}")
                continue
            known = explained[words[0]] | OF_THE_SCENE
            for heading in headings(words[0], run.stdout):
                n_looked_up += 1
                left = unexplained(heading, known)
                if left:
                    faults.append(f"{words[0]}: docs/glossary.md does not explain {left} of \"{heading.strip()}\"")
            if "--why" in words:
                for part in parts_of_the_model(run.stdout):
                    n_looked_up += 1
                    if part.lower() not in known:
                        faults.append(f"check --why: docs/glossary.md does not explain \"{part}\"")
    print(f"{n_looked_up} headings and names looked up, {len(faults)} faults")
    for fault in faults:
        print(fault)
    return 1 if faults or n_looked_up < 30 else 0


def labels(file):
    """Two labels side by side, in 8 x 8 x 12 voxels."""
    voxels = bytes(0 if not (1 <= i < 7 and 1 <= j < 7 and 1 <= k < 11) else 17 if i < 4 else 5
                   for k in range(12) for j in range(8) for i in range(8))
    file.write_bytes(b"ObjectType = Image\nNDims = 3\nBinaryData = True\nAnatomicalOrientation = RAI\nDimSize = 8 8 12\nElementSpacing = 2 2 2\n"
                     b"ElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + voxels)


if __name__ == "__main__":
    sys.exit(main())
