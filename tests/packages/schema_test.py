"""docs/scene.schema.json, made of scene/keys.toml, has exactly the keys that the readers know, table by table.

The readers say which keys they know where one is unknown ("one of: ..."), so each table is read in all its forms with a key that nobody
knows, by `maille check`. Every scene of the repository obeys the schema as well, where Python's jsonschema is there to judge.
schema_test.py MAILLE SOURCES
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import tomllib

MAILLE, SOURCES = sys.argv[1], pathlib.Path(sys.argv[2])
SCHEMA = json.loads((SOURCES / "docs/scene.schema.json").read_text(encoding="utf-8"))
UNKNOWN = "zzz_unknown"

BOX = 'shape = "box"\ncells = [4, 4, 4]\nspacing = "1 mm"\nmaterial = "muscle/soleus"\n'
FLAT = 'shape = "box"\ncells = [4, 4]\nspacing = "1 mm"\nmaterial = "muscle/soleus"\n'
IMAGE = 'shape = "image"\nimage = "labels.mha"\n'
LABELS = 'labels = { 1 = "muscle/soleus", 2 = "muscle/gastrocnemius" }\n'
FIBRED = LABELS + 'fibre = [1, 0, 0]\n'
OWN = "{ youngs_modulus = '10 kPa', poisson_ratio = 0.3 }"
PLACE = '[0, 0, 0]'


def scene(specimen=BOX, rest=""):
    return f"[specimen]\n{specimen}{rest}"


def of_image(rest, specimen=IMAGE + FIBRED):
    return scene(specimen, rest)


def world(thing):
    return f'[world]\ncells = [8, 8, 8]\nspacing = "1 mm"\n[[object]]\nname = "a"\n{thing}'


def hold(where, body=None):
    text = f"[[hold]]\nwhere = {where}\n"
    return of_image(text) if body == "image" else scene(rest=text)


MOVING = '[world]\ncells = [8, 8, 8]\nspacing = "1 mm"\ndynamics = { gravity = [0, 0, -9.81], restitution = 1, damping = 0 }\n'

# Pointer into the schema, and the forms of that table; %s is where the unknown key goes (in a line of its own, or inside braces).
LINE, INSIDE = f"{UNKNOWN} = 1\n", f", {UNKNOWN} = 1"
MATERIAL = "definitions/material/anyOf/1"
TABLES = {
    "": [LINE + scene(), LINE + world('kind = "fixed"\n' + BOX)],
    "definitions/specimen": [
        scene(BOX + LINE), scene(FLAT + LINE), scene(BOX.replace("box", "ellipsoid") + LINE),
        scene(BOX.replace("box", "muscle") + f'tendon = {{ material = "tendon/achilles", fraction = 0.2 }}\n{LINE}'),
        scene(BOX + 'look = { colour = "#aa3322" }\n' + LINE),
        scene(IMAGE + FIBRED + 'stiffness = { image = "labels.mha", unit = "kPa" }\n' + LINE),
        scene('shape = "surface"\nsurface = "a.stl"\nspacing = "1 mm"\nunit = "mm"\n' + LINE), scene(IMAGE + 'material = "muscle/soleus"\nthreshold = 0\n' + LINE)],
    "definitions/stiffness": [scene(IMAGE + FIBRED + f'stiffness = {{ image = "labels.mha", {keys}{INSIDE} }}\n') for keys in (
        'unit = "kPa", quantity = "shear_modulus", labels = 1', 'law = "morgan_2003_vertebra", density = ["0.02 g/cm^3", "0.1 g/cm^3"]')],
    "definitions/tendon": [
        scene(BOX.replace("box", "muscle") + f'tendon = {{ material = "tendon/achilles", fraction = 0.2{INSIDE} }}\n')],
    MATERIAL: [scene(BOX.replace('"muscle/soleus"', form.replace(" }", INSIDE + " }"))) for form in (
        OWN, '{ E = ["1 kPa", "1 kPa", "1 kPa"], nu = [0.3, 0.3, 0.3], G = ["1 kPa", "1 kPa", "1 kPa"] }',
        '{ E_fibre = "20 kPa", E_cross = "10 kPa", G_fibre = "5 kPa", nu_fibre = 0.3, nu_cross = 0.3 }',
        "{ youngs_modulus = '10 kPa', poisson_ratio = 0.3, stretch = 1.2, compress = 0.8, shear = 0.1 }",
        "{ law = 'neo_hookean', E = '10 kPa', nu = 0.3 }", "{ law = 'mooney_rivlin', parameters = {c1 = 1, c2 = 0, k = 9} }")],
    "definitions/damage": [
        scene(BOX.replace('"muscle/soleus"', f"{{ youngs_modulus = '10 kPa', poisson_ratio = 0.3, damage = {{ stretch = 1.4{INSIDE} }} }}"))],
    "definitions/fibre/anyOf/1": [
        scene(BOX + f'fibre = {{ direction = [0, 0, 1], frame = "grid"{INSIDE} }}\n'),
        scene(BOX + f'fibre = {{ angle = "20 deg", plane = "xz"{INSIDE} }}\n'),
        scene(BOX + f'fibre = {{ angle = "20 deg", plane = "xz", bipennate = true{INSIDE} }}\n'),
        scene(BOX + f'fibre = {{ curve = [[0, 0, 0], ["1 mm", 0, 0]]{INSIDE} }}\n'),
        scene(IMAGE + LABELS + f'fibre = {{ tensor_image = "tensors.nii.gz", smooth = "2 mm"{INSIDE} }}\n')],
    "definitions/hold": [scene(rest='[[hold]]\nwhere = "x-"\nframe = "grid"\n' + LINE)],
    "definitions/move": [scene(rest='[[move]]\nwhere = "x-"\nby = ["1 mm", 0, 0]\nframe = "grid"\n' + LINE),
                         scene(rest='[[move]]\nwhere = "x-"\nfield = { points = "a.csv", within = "1 mm" }\n' + LINE),
                         scene(rest='[[move]]\nwhere = "x-"\nturn = { angle = "2 deg", axis = [0, 0, 1] }\n' + LINE)],
    "definitions/field": [scene(rest=f'[[move]]\nwhere = "x-"\nfield = {{ {keys}{INSIDE} }}\n') for keys in (
        'points = "a.csv", within = "1 mm"', 'image = "a.nii", unit = "mm"')],
    "definitions/turn": [scene(rest=f'[[move]]\nwhere = "x-"\nturn = {{ angle = "2 deg", axis = [0, 0, 1], about = {PLACE}{INSIDE} }}\n')],
    "definitions/load": [scene(rest=f"[[load]]\n{text}\n{LINE}") for text in (
        'where = "x+"\ntraction = ["1 kPa", 0, 0]', 'where = "x+"\nframe = "grid"\nforce = ["1 N", 0, 0]', 'where = "x+"\npressure = "1 kPa"', 'gravity = [0, 0, -9.81]',
        'where = "x+"\nfoundation = "10 kPa/mm"\nalong = "normal"', 'contraction = "1 kPa"\nmaterial = "muscle/soleus"')] + [of_image(f'[[load]]\ncontraction = "1 kPa"\nlabels = 1\n{LINE}')],
    "definitions/region/anyOf/1": [hold(f"{{ {inside}{INSIDE} }}", body) for inside, body in (
        ('box = [[0, 0, 0], ["1 mm", "1 mm", "1 mm"]], frame = "grid"', None), (f'sphere = {{ centre = {PLACE}, radius = "2 mm" }}', None),
        ("label = 1", "image"), ("label = 1, touching = 2", "image"), ('label = 1, end = "x-", depth = "1 mm"', "image"),
        ('image = "labels.mha", value = 1, resample = true', "image"), ('surface = "a.stl", within = "1 mm", unit = "mm"', None),
        ('points = "a.fcsv", within = "1 mm", name = "F-1"', None), ('any = ["x-"]', None), ('all = ["x-"]', None), ('not = "x-"', None))],
    "definitions/sphere": [hold(f'{{ sphere = {{ centre = {PLACE}, radius = "2 mm"{INSIDE} }} }}')],
    "definitions/drive": [of_image(f'[[drive]]\nlabel = 1\n{keys}\n{LINE}') for keys in (
        'by = ["1 mm", 0, 0]\ncourse = [[0, 0], [1, 1]]', 'poses = "poses.csv"\nabout = [0, 0, 0]')] + [scene(
            rest='[[drive]]\nwhere = "x+"\nframe = "grid"\nturn = { angle = "2 deg", axis = [0, 0, 1] }\n' + LINE)],
    "definitions/sliding": [of_image('[[sliding]]\nbetween = [1, 2]\n' + LINE)],
    "definitions/partial_volume/anyOf/1": [scene(IMAGE + FIBRED + f"partial_volume = {{ {keys}{INSIDE} }}\n") for keys in (
        'smooth = "1 mm"', 'none = 0, full = 2, image = "labels.mha", least = 0.1')],
    "definitions/look": [scene(IMAGE + FIBRED + f'look = {{ {keys}{INSIDE} }}\n') for keys in (
        'preset = "grey", window = [0, 2], unit_distance = "1 mm", around = "all"', 'colours = [[0, "#000000"], [2, "#ffffff"]], opacity = [[0, 0], [2, 1]]',
        'colour = "#aa3322", labels = { 1 = "#aa3322" }, shading = true', 'image = "labels.mha", mode = "isosurface", isovalue = 1, ambient = 0.1')],
    "definitions/limits": [scene(rest=f'[limits]\nfrom = "{source}"\n{keys}{LINE}') for source, keys in (
        ("given", "stretch = 1.2\ncompress = 0.8\nshear = 0.1\n"), ("material", ""))],
    "definitions/relaxation": [scene(rest="[relaxation]\n" + LINE)],
    "definitions/test": [scene(rest=f'[test]\naxis = "z"\nstrain = "1 %"\nkind = "{kind}"\n{LINE}') for kind in
                         ("axial", "shear", "bend", "indent", "confined")],
    "definitions/measure": [scene(rest=f'[[hold]]\nwhere = "x-"\n[[measure]]\nname = "m"\nframe = "grid"\n{text}\n{LINE}') for text in (
        'force = "hold[1]"', f"displacement = {{ at = {PLACE} }}", f"strain = {{ at = {PLACE} }}", 'stress = { mean = "body" }',
        f'length = [{PLACE}, ["1 mm", 0, 0]]', f'angle = [{PLACE}, ["1 mm", 0, 0], [0, "1 mm", 0]]', 'volume = "body"', 'energy = "body"')],
    "definitions/force/anyOf/1": [
        scene(rest=f'[[measure]]\nname = "m"\nforce = {{ {text}{INSIDE} }}\n') for text in
        ('where = "x-"', f"section = {{ point = {PLACE}, normal = [1, 0, 0] }}")],
    "definitions/section": [
        scene(rest=f'[[measure]]\nname = "m"\nforce = {{ section = {{ point = {PLACE}, normal = [1, 0, 0]{INSIDE} }} }}\n')],
    "definitions/measure_place": [scene(rest=f'[[measure]]\nname = "m"\nstrain = {{ {text}{INSIDE} }}\n') for text in
                                  (f"at = {PLACE}", f'along = [{PLACE}, ["1 mm", 0, 0]], points = 3', 'mean = "body"')],
    "definitions/part/anyOf/1": [of_image(f'[[measure]]\nname = "m"\nvolume = {{ {text}{INSIDE} }}\n') for text in
                                 ("label = 1", 'material = "muscle/soleus"', 'where = "x-"', f'sphere = {{ centre = {PLACE}, radius = "9 mm" }}')],
    "definitions/world": [f'[world]\ncells = [8, 8, 8]\nspacing = "1 mm"\n{LINE}[[object]]\nname = "a"\nkind = "fixed"\n{BOX}'],
    "definitions/object": [world(f'kind = "{kind}"\n{text}\n{LINE}') for kind, text in (
        ("deformable", BOX), ("deformable", BOX.replace("box", "muscle") + 'tendon = { material = "tendon/achilles" }'),
        ("rigid", IMAGE + "threshold = 0"), ("deformable", IMAGE + FIBRED), ("rigid", 'shape = "rows"\nrows = ["#"]'),
        ("rigid", 'shape = "bolt"\ncells = [8, 8, 8]\nhead = "2 mm"\nthread = { radius = "3 mm", depth = "1 mm", pitch = "2 mm", play = 0 }'),
        ("rigid", 'shape = "nut"\ncells = [8, 8, 8]\nthread = { radius = "2 mm", depth = "1 mm", pitch = "2 mm", play = 0 }'),
        ("rigid", 'shape = "washer"\ncells = [8, 8, 2]\nhole = "2 mm"'), ("rigid", 'shape = "puzzle_piece"\ncells = [8, 8]\npieces = [2, 2]\npiece = [0, 0]'))]
        + [world('kind = "rigid"\nshape = "box"\ncells = [4, 4, 4]\nposition = [0, 0, 0]\nlook = { colour = "#aa3322" }\n' + LINE),
           MOVING + f'[[object]]\nname = "a"\nkind = "rigid"\n{BOX}velocity = [1, 0, 0]\ndensity = "1 g/cm^3"\n{LINE}'],
    "definitions/dynamics": [MOVING.replace(" }", INSIDE + " }")],
    "definitions/thread": [world(
        f'kind = "rigid"\nshape = "bolt"\ncells = [8, 8, 8]\nhead = "2 mm"\nthread = {{ radius = "3 mm", depth = "1 mm", pitch = "2 mm", play = 0{INSIDE} }}')],
}


def known_keys(folder, text):
    """Those that the reader lists where it meets the unknown one."""
    (folder / "scene.toml").write_text(text, encoding="utf-8")
    run = subprocess.run([MAILLE, "check", folder / "scene.toml", "--json"], capture_output=True, text=True, check=False)
    faults = json.loads(run.stdout)["faults"]
    lists = [fault["expected"] for fault in faults if fault["key"].split(".")[-1] == UNKNOWN and fault["expected"].startswith("one of: ")]
    if len(lists) != 1:
        raise SystemExit(f"expected one fault that lists the keys of a table, found {len(lists)}:\n{text}\n{run.stdout}{run.stderr}")
    return set(lists[0].removeprefix("one of: ").split(", "))


def at(pointer):
    node = SCHEMA
    for step in pointer.split("/") if pointer else []:
        node = node[int(step) if isinstance(node, list) else step]
    return node


def compare_keys():
    wrong = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        voxels = bytes([1] * 32 + [2] * 32)
        (folder / "labels.mha").write_bytes(
            b"ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementSpacing = 1 1 1\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + voxels)
        for pointer, forms in TABLES.items():
            known = set().union(*(known_keys(folder, form) for form in forms))
            written = set(at(pointer)["properties"])
            if known != written:
                wrong.append(f"{pointer or '(root)'}: the readers alone know {sorted(known - written)}, the schema alone {sorted(written - known)}")
    return wrong


def judge_scenes():
    try:
        import jsonschema
    except ImportError:
        print("jsonschema is not installed: scenes were not judged")
        return []
    judge = jsonschema.Draft7Validator(SCHEMA)
    files = [file for file in sorted(SOURCES.glob("scene/scenes/**/*.toml")) + sorted(SOURCES.glob("studies/anisotropy/scenes/*.toml"))
             if tomllib.loads(file.read_text(encoding="utf-8")).keys() & {"specimen", "world"}]
    wrong = [f"{file}: {list(error.absolute_path)}: {error.message}" for file in files
             for error in judge.iter_errors(tomllib.loads(file.read_text(encoding="utf-8")))]
    faulty = [scene(BOX + LINE), scene(BOX.replace("cells", "cell")), scene(rest="[test]\nkind = \"axial\"\n")]
    wrong += [f"the schema finds nothing wrong with\n{text}" for text in faulty if judge.is_valid(tomllib.loads(text))]
    print(f"{len(files)} scenes judged")
    return wrong


def judge_examples():
    """Every key has one, which obeys what the key takes."""
    try:
        import jsonschema
    except ImportError:
        return []
    wrong, n_judged = [], 0

    def look(node, place):
        nonlocal n_judged
        if isinstance(node, list):
            for n, one in enumerate(node):
                look(one, f"{place}/{n}")
        if not isinstance(node, dict):
            return
        keys = node.get("properties", {})
        for key, taken in keys.items() if "type" in node or place == "" else ():
            examples = taken.get("examples", [])
            wrong.extend([] if examples else [f"{place}/properties/{key} has no example"])
            judge = jsonschema.Draft7Validator({**taken, "definitions": SCHEMA["definitions"]})
            if "$ref" in taken:
                judge = jsonschema.Draft7Validator({"$ref": taken["$ref"], "definitions": SCHEMA["definitions"]})
            for example in examples:
                n_judged += 1
                wrong.extend(f"{place}/properties/{key}: {example}: {error.message}" for error in judge.iter_errors(example))
        for key, one in node.items():
            if key != "examples":
                look(one, f"{place}/{key}")

    look(SCHEMA, "")
    print(f"{n_judged} examples judged")
    return wrong


faults = compare_keys() + judge_scenes() + judge_examples()
print("\n".join(faults))
sys.exit(1 if faults else 0)
