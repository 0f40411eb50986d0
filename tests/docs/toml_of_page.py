"""Every TOML snippet of one page is what `maille check` takes: toml_of_page.py MAILLE SOURCES PAGE

A snippet that is a part of a scene is completed first: by a strip, or by a body of labels, whichever has what it speaks of; in a folder with images,
surfaces and landmarks under the names that pages use. Keys without a table belong to [specimen], one at a time where they are the same key;
`# key = value` stands for a line that may take the place of the one above, and is tried in it. Snippets that begin with `# NAME.toml`
are left to commands_of_page.py, which runs what their page does with them.
"""
import gzip
import os
import pathlib
import re
import struct
import subprocess
import sys
import tempfile

from commands_of_page import blocks, print_figure

HELD = '\n[[hold]]\nwhere = "z-"\n'
MOVED = '\n[[move]]\nwhere = "z+"\nby = [0, 0, "0.5 mm"]\n'
STRIP = '[specimen]\nshape = "box"\ncells = [32, 8, 8]\nspacing = "1 mm"\nmaterial = "muscle/vastus_lateralis"\nfibre = [1, 0, 0]\n'
MUSCLE = '[specimen]\nshape = "image"\nimage = "labels.nii.gz"\nlabels = { 17 = "muscle/soleus" }\nfibre = [0, 0, 1]\n'
LEG = ('[specimen]\nshape = "image"\nimage = "labels.nii.gz"\nlabels = { 17 = "muscle/soleus", 19 = "muscle/soleus", "20..24" = "muscle/soleus", '
       '30 = "bone/cortical_tibia" }\nfibre = [0, 0, 1]\n')
SIZE, MILLIMETRES = (16, 16, 24), 2


def label_at(i, j, k):
    """A muscle 17, on which a bone 30 sits, beside a muscle 19 and slices of 20 to 24."""
    if not (2 <= i < 14 and 2 <= j < 14 and 2 <= k < 22):
        return 0
    if i < 8:
        return 17 if k < 19 else 30
    return 19 if j < 8 else 20 + (k - 2) // 4


def nifti(file, values):
    """Float32 on the grid of the labels, right-anterior-superior."""
    header = bytearray(352)
    struct.pack_into("<i", header, 0, 348)
    struct.pack_into("<8h", header, 40, 3, *SIZE, 1, 1, 1, 1)
    struct.pack_into("<2h", header, 70, 16, 32)
    struct.pack_into("<8f", header, 76, 1, *[MILLIMETRES] * 3, 1, 1, 1, 1)
    struct.pack_into("<f", header, 108, 352)
    struct.pack_into("<B", header, 123, 2)
    struct.pack_into("<2h", header, 252, 0, 1)
    for axis in range(3):
        struct.pack_into("<4f", header, 280 + 16 * axis, *[MILLIMETRES if a == axis else 0 for a in range(3)], 0)
    header[344:348] = b"n+1\0"
    with gzip.open(file, "wb", 1) as stream:
        stream.write(bytes(header) + struct.pack(f"<{len(values)}f", *values))


def segmentation(file):
    """Of 3D Slicer: two segments side by side."""
    names = ["Soleus", "Gastrocnemius medialis"]
    head = ("NRRD0005\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 8 8 8\nspace directions: (2,0,0) (0,2,0) (0,0,2)\n"
            "kinds: domain domain domain\nencoding: raw\nspace origin: (0,0,0)\n")
    head += "".join(f"Segment{n}_ID:=Segment_{n + 1}\nSegment{n}_LabelValue:={n + 1}\nSegment{n}_Layer:=0\nSegment{n}_Name:={name}\n"
                    for n, name in enumerate(names))
    voxels = bytes(1 + (i >= 4) if 1 <= i < 7 and 1 <= j < 7 and 1 <= k < 7 else 0 for k in range(8) for j in range(8) for i in range(8))
    file.write_bytes(head.encode() + b"\n" + voxels)


def box_surface(at, length):
    """Corners and triangles of a closed box."""
    corners = [tuple(at[a] + length * (n >> a & 1) for a in range(3)) for n in range(8)]
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return corners, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]


def prepare(folder, sources):
    for name in ("scene", "studies", "materials"):
        (folder / name).symlink_to(sources / name)
    (folder / "scenes").symlink_to(sources / "studies/anisotropy/scenes")
    labels = [label_at(i, j, k) for k in range(SIZE[2]) for j in range(SIZE[1]) for i in range(SIZE[0])]
    (folder / "data/calf_mri").mkdir(parents=True)
    for name in ("labels.nii.gz", "leg.nii.gz", "data/calf_mri/labels.nii.gz"):
        nifti(folder / name, labels)
    nifti(folder / "mre.nii.gz", [3 + (n % 5) for n in range(len(labels))])
    nifti(folder / "ct.nii.gz", [600 + (n % 7) for n in range(len(labels))])
    nifti(folder / "water.nii.gz", [100 + (n % 9) for n in range(len(labels))])
    nifti(folder / "share.nii.gz", [float(label != 0) for label in labels])
    segmentation(folder / "calf.seg.nrrd")
    corners, triangles = box_surface((0, 0, 0), 10)
    (folder / "bone.stl").write_text("solid bone\n" + "".join(
        "facet normal 0 0 0\nouter loop\n" + "".join("vertex {} {} {}\n".format(*corners[c]) for c in t) + "endloop\nendfacet\n" for t in triangles)
        + "endsolid bone\n")
    corners, triangles = box_surface((10, 0, 0), 10)
    (folder / "muscle.obj").write_text("".join("v {} {} {}\n".format(*c) for c in corners) + "".join(
        "f {} {} {}\n".format(*(n + 1 for n in t)) for t in triangles))
    (folder / "landmarks.fcsv").write_text("# Markups fiducial file version = 4.11\n# CoordinateSystem = RAS\n"
                                           "# columns = id,x,y,z,ow,ox,oy,oz,vis,sel,lock,label,desc,associatedNodeID\n"
                                           "1,10,16,4,0,0,0,1,1,1,0,F-1,,\n")


def variants(lines):
    """The snippet as it stands, and once more for each line that may take the place of another."""
    yield lines
    for at, line in enumerate(lines):
        found = re.match(r"#\s+((\w+)\s*=.*)$", line)
        if found:
            key = re.compile(rf"{found.group(2)}\s*=")
            yield [found.group(1) if n == at else other for n, other in enumerate(lines) if n == at or not key.match(other)]


def keys_alone(lines):
    """The lines one at a time, where they are one key of no table."""
    keys = [re.match(r"(\w+)\s*=", line) for line in lines if line.strip() and not line.startswith("#")]
    if len(keys) > 1 and all(keys) and len({key.group(1) for key in keys}) == 1:
        return [[line] for line in lines if line.strip()]
    return [lines]


def completed(lines):
    """Whole scenes that the snippet may be a part of; the last is the one whose faults are told."""
    text = "\n".join(lines) + "\n"
    if re.search(r"^\[world\]|^\[\[parameter\]\]", text, re.M):
        return [text]
    is_condition = re.search(r"^\[\[(move|load|drive)\]\]|^\[test\]", text, re.M)
    held = "" if re.search(r"^\[\[hold\]\]|^\[test\]", text, re.M) else HELD
    rest = held + ("" if is_condition else MOVED)
    if re.search(r"^\[specimen\]", text, re.M):
        return [text + rest]
    first = next((line for line in lines if line.strip() and not line.startswith("#")), "[")
    own = re.search(r"^fibre\s*=", text, re.M)  # in place of the body's
    return [(re.sub(r"fibre = .*\n", "", specimen) if own else specimen) + text + rest for specimen in ((STRIP, MUSCLE, LEG) if first.startswith("[") else (MUSCLE, LEG))]


def check(maille, folder, *names):
    run = subprocess.run([maille, "check", *names], cwd=folder, capture_output=True, text=True, errors="replace",
                         env={**os.environ, "MAILLE_DATA": str(folder / "data")})
    return None if run.returncode == 0 else run.stdout + run.stderr


def main():
    maille, sources, name = sys.argv[1], pathlib.Path(sys.argv[2]), sys.argv[3]
    n_checked, faults = 0, []
    with tempfile.TemporaryDirectory(prefix="maille-toml-") as temporary:
        folder = pathlib.Path(temporary)
        prepare(folder, sources)
        for language, lines in blocks(sources / name):
            if language != "toml" or (lines and re.match(r"#\s+(?:example:\s+)?[\w./-]+\.(?:toml|csv)\b", lines[0])):
                continue
            is_trajectory = any(re.match(r"frame_time\s*=|frames\s*=", line) for line in lines)
            is_world = any(line.startswith("[world]") for line in lines)
            for part in keys_alone(lines):
                for variant in variants(part):
                    n_checked += 1
                    if is_trajectory:
                        (folder / "trajectory.toml").write_text("\n".join(variant) + "\n", encoding="utf-8")
                        fault = check(maille, folder, "world.toml", "trajectory.toml")
                    else:
                        file = "world.toml" if is_world and variant is part else "snippet.toml"
                        for text in completed(variant):
                            (folder / file).write_text(text, encoding="utf-8")
                            fault = check(maille, folder, file)
                            if fault is None:
                                break
                    if fault:
                        faults.append("\n".join(variant) + "\n" + fault)
    print(f"{name}: {n_checked} snippets of TOML checked, {len(faults)} faulty")
    print("\n".join(faults))
    print_figure(len(faults))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
