"""Bodies of scenes that are no boxes: images of labels, and scenes drawn by lot. The numbers are those of std::mt19937, the same everywhere."""
import math
import random


class Lot:
    def __init__(self, seed):
        state = [seed]
        for i in range(1, 624):
            state.append((1812433253 * (state[-1] ^ state[-1] >> 30) + i) & 0xFFFFFFFF)
        self.random = random.Random()
        self.random.setstate((3, (*state, 624), None))

    def next(self):
        return self.random.getrandbits(32)

    def between(self, low, high):
        return low + (high - low) * self.next() / 2**32

    def whole(self, low, high):
        return low + self.next() % (high - low + 1)

    def on_logarithm(self, low, high):
        return math.exp(self.between(math.log(low), math.log(high)))


HELD_X, MOVED_X = '[[hold]]\nwhere = "x-"\n', '[[move]]\nwhere = "x+"\n'


def box_of(shape, cells, material):
    return f'units = "m, rad"\n[specimen]\nshape = "{shape}"\ncells = {list(cells)}\nspacing = "1 mm"\nmaterial = {material}\n'


def drawn_scene(lot, number):
    """A box, ellipsoid or belly; pulled, bent or poked; isotropic, or a tissue with fibres."""
    tissues = ["muscle/vastus_lateralis", "muscle/soleus", "muscle/gastrocnemius", "fat/subcutaneous", "muscle/strongly_anisotropic"]
    shape, action = ["box", "ellipsoid", "muscle"][number % 3], ["pull", "bend", "poke"][number // 3 % 3]
    is_even = shape == "box" and lot.whole(0, 2) > 0
    x, y, z = (2 * lot.whole((low + 1) // 2, high // 2) if is_even else lot.whole(low, high) for low, high in ((8, 14), (8, 10), (8, 10)))
    tissue = lot.whole(0, 9)
    matter = f'"{tissues[tissue]}"' if tissue < 5 else f'{{ youngs_modulus = "10 kPa", poisson_ratio = {[0, 0.3, 0.45, 0.49][lot.whole(0, 3)]} }}'
    text = box_of(shape, (x, y, z), matter) + f'fibre = {{ angle = "{lot.between(0, 40):.4g} deg", plane = "xz" }}\n'
    if shape == "muscle":
        text += 'tendon = { material = "tendon/tibialis_anterior", fraction = 0.15 }\n'
    part = lot.between(0.01, 0.1)
    if action == "poke":
        corners = [[1e-3 * (2 * (n // 4) + side * 2 * (n // 8)) for n in (x, y)] + [height * 1e-3 * z] for side, height in ((-1, 0.75), (1, 1))]
        text += f'[[hold]]\nwhere = "z-"\n[[move]]\nwhere = {{ box = {corners} }}\nby = [0, 0, {-part * 1e-3 * z:.6g}]\n'
    else:
        by = f"{part * 1e-3 * x:.6g}"
        text += HELD_X + MOVED_X + (f"by = [{by}, 0, 0]\n" if action == "pull" else f"by = [0, 0, {by}]\n")
    return f"{number}: {shape} {x} x {y} x {z}, {action}, {matter}", text, {}


def drawn_strip(lot, number):
    matter = ['"muscle/vastus_lateralis"', '"muscle/soleus"'] + [f'{{ youngs_modulus = "10 kPa", poisson_ratio = {nu} }}' for nu in (0.45, 0.49)]
    size = [2 * int(lot.between(low / 2, high / 2 + 1)) for low, high in ((20, 30), (6, 8), (4, 6))]
    material, is_bent = matter[lot.next() % 4], lot.next() % 2 == 0
    by, angle = 1e-3 * size[0] * lot.between(0.02, 0.1), lot.between(0, 20)
    text = box_of("box", size, material) + f'fibre = {{ angle = "{angle:.4g} deg", plane = "xz" }}\n' + HELD_X + MOVED_X
    return f"{number}: strip {size}, {'bend' if is_bent else 'pull'}, {material}", text + f"by = [{0 if is_bent else by:.6g}, 0, {by if is_bent else 0:.6g}]\n", {}


def with_strips(n, seed):
    """Every fifth drawn scene is a slender box."""
    strips = Lot(seed)
    return [drawn_strip(strips, i) if i % 5 == 4 else scene for i, scene in enumerate(scenes(n, seed))]


def scenes(n, seed):
    lot = Lot(seed)
    return [drawn_scene(lot, i) for i in range(n)]


def unseen_scene(lot):
    """A scene unlike those of studies/trade/table.csv, and a wish: its error and its time [s]."""
    draw = lot.whole(0, 3)
    shape = "box" if draw < 2 else "ellipsoid" if draw == 2 else "muscle"
    is_even = lot.whole(0, 3) > 0
    cells = [lot.whole(8, 12) if shape != "box" or not is_even else 4 * lot.whole(2, 8 if lot.whole(0, 5) == 0 else 4) for _ in range(3)]
    if shape == "muscle":
        cells[0] = lot.whole(16, 24)
    if lot.whole(0, 1) == 0:
        nu, modulus = lot.between(0, 0.49), lot.on_logarithm(1, 100)
        words, material = f"nu {nu:.2f}", f'{{ youngs_modulus = "{modulus:.4g} kPa", poisson_ratio = {nu:.3f} }}'
    else:
        ratio, modulus, angle = lot.between(1, 20), lot.on_logarithm(1, 50), lot.between(0, 90)
        words = f"fibres {ratio:.1f}:1, {angle:.0f} deg"
        material = (f'{{ E_fibre = "{ratio * modulus:.4g} kPa", E_cross = "{modulus:.4g} kPa", G_fibre = "{modulus * lot.between(0.25, 0.5):.4g} kPa", '
                    f'nu_fibre = {lot.between(0.2, 0.4):.3f}, nu_cross = {lot.between(0.2, 0.45):.3f} }}\nfibre = {{ angle = "{angle:.1f} deg", plane = "xz" }}')
    kind = lot.whole(0, 2 if shape == "box" else 1)
    if kind < 2:
        by = f'"{cells[0] * lot.between(0.02, 0.1):.4g} mm"'
        load = HELD_X + MOVED_X + (f"by = [{by}, 0, 0]\n" if kind == 0 else f"by = [0, 0, {by}]\n")
    else:
        sides = []
        for n in cells[:2]:
            side = n * lot.between(0.2, 0.5)
            low = n * 0.05 + (n * 0.9 - side) * lot.between(0.2, 0.8)
            sides.append((low, low + side))
        corners = [[f"{sides[0][i]:.3f} mm", f"{sides[1][i]:.3f} mm", f"{cells[2]} mm"] for i in (0, 1)]
        load = f'[[hold]]\nwhere = "z-"\n[[move]]\nwhere = {{ box = {corners} }}\nby = [0, 0, "{-cells[2] * lot.between(0.03, 0.15):.4g} mm"]\n'
    text = box_of(shape, cells, material)
    if shape == "muscle":
        text += f'tendon = {{ material = {{ youngs_modulus = "{lot.on_logarithm(100, 2000):.4g} kPa", poisson_ratio = 0.35 }}, fraction = {lot.between(0.08, 0.2):.2f} }}\n'
    wish = {"wish": lot.on_logarithm(0.015, 0.4), "seconds": lot.on_logarithm(0.3e-3, 0.3)}
    return f"{shape} {cells}, {['pull', 'bend', 'poke'][kind]}, {words}", text + load, wish


def unseen(n, seed):
    """Wishes of all kinds; `force`: of 5, 10, 20 and 40 % by turns."""
    lot = Lot(seed)
    return [(f"{i}: {name}", text, wish | {"of_force": [0.05, 0.1, 0.2, 0.4][i % 4]}) for i in range(n) for name, text, wish in [unseen_scene(lot)]]


def large_scene(lot, number):
    """A body at large strain: bulk over shear to 1e4, fibres over matrix to 1e3, stretch 0.5 to 3, contraction to 400 kPa."""
    shear, bulk, fibres = lot.on_logarithm(1e3, 1e5), lot.on_logarithm(10, 1e4), lot.on_logarithm(1, 1e3)
    k, nu = shear * bulk, lot.between(0, 0.4999)
    kind = ["neo_hookean", "mooney_rivlin", "guccione", "holzapfel_gasser_ogden", "muscle"][number % 5]
    parameters = {"mooney_rivlin": {"c1": shear / 3, "c2": shear / 6, "k": k}, "guccione": {"C": shear, "bf": min(30, 1 + fibres / 4), "bt": 2, "bfs": 2, "k": k},
                  "holzapfel_gasser_ogden": {"c": shear, "k1": shear * fibres, "k2": lot.between(0.1, 2), "kappa": lot.between(0, 0.33), "k": k},
                  "muscle": {"g1": shear / 2, "g2": shear / 2, "g3": 2 / 3 * shear, "p1": 0.05, "p2": 6.6, "Lofl": 1.1, "lam_max": 1.4, "smax": shear * fibres, "activation": lot.between(0, 1), "k": k}}
    matter = f'{{ law = "neo_hookean", E = {2 * shear * (1 + nu):.6g}, nu = {nu:.4f} }}' if kind == "neo_hookean" else (
        f'{{ law = "{kind}", parameters = {{ ' + ", ".join(f"{key} = {value:.6g}" for key, value in parameters[kind].items()) + " } }")
    cells = [lot.whole(6, 10), lot.whole(2, 4), lot.whole(2, 4)]
    text = 'strain = "finite"\n' + box_of("box", cells, matter) + f'fibre = {{ angle = "{lot.between(0, 60):.3g} deg", plane = "xz" }}\n' + HELD_X
    action = lot.whole(0, 3)
    if action == 0:
        text += MOVED_X + f"by = [{1e-3 * cells[0] * (lot.on_logarithm(0.5, 3) - 1):.6g}, 0, 0]\n"
    elif action == 1:
        text += MOVED_X + f'turn = {{ angle = "{lot.between(10, 150):.4g} deg", axis = {[[1, 0, 0], [0, 1, 0]][lot.whole(0, 1)]} }}\n'
    else:
        text += (f"[[load]]\ncontraction = {lot.on_logarithm(1e3, 4e5):.6g}\n" if action == 2
                 else f'[[load]]\nwhere = "z-"\npressure = {shear * lot.on_logarithm(1e-4, 0.1):.6g}\n')
    return f"random {number}: {kind}, {['stretch', 'turn', 'contraction', 'pressure'][action]}, {cells}", text, {}


def large(n, seed):
    lot = Lot(seed)
    return [large_scene(lot, i) for i in range(n)]


DRAWN = {"large": large, "scenes": scenes, "with strips": with_strips, "unseen": unseen}


def gyroid(n, period, solid, filling=0):
    """Labels of the larger half of a gyroid's network: cells whose sin x cos y + sin y cos z + sin z cos x is among the highest share `solid`, the
    largest piece that is joined by faces; elsewhere `filling`. @pre n is a multiple of the period"""
    wave = [(math.sin(angle), math.cos(angle)) for angle in (2 * math.pi * (i + 0.5) / period for i in range(period))]
    values = [sx * cy + sy * cz + sz * cx for sz, cz in wave for sy, cy in wave for sx, cx in wave]
    least = sorted(values)[int((1 - solid) * len(values))]
    tiles = n // period
    rows = [bytes(v > least for v in values[i : i + period]) * tiles for i in range(0, len(values), period)]
    layers = [b"".join(rows[z * period : (z + 1) * period]) * tiles for z in range(period)]
    side = n + 1  # a border of 0 after every row and layer, so that no step leaves the image
    padded = b"".join(b"".join(row + b"\0" for row in (layer[i : i + n] for i in range(0, n * n, n))) + bytes(side) for layer in layers * tiles)
    piece = bytearray(padded) + bytes(side * side)
    best, steps = b"", (1, -1, side, -side, side * side, -side * side)
    start = piece.find(1)
    found = []
    while start >= 0:
        piece[start] = 2
        cells = [start]
        for at in cells:  # grows as it goes
            for step in steps:
                if piece[at + step] == 1:
                    piece[at + step] = 2
                    cells.append(at + step)
        if len(cells) > len(found):
            found = cells
        start = piece.find(1, start)
    labels = bytearray([filling]) * (side * side * n)
    for at in found:
        labels[at] = 1
    return b"".join(labels[(z * side + y) * side : (z * side + y) * side + n] for z in range(n) for y in range(n))


def write_image(folder, label, cells, scale=1):
    """A MetaImage with cells of 1 / scale mm, whose labels an expression gives in x, y, z, the place of a cell's middle [mm]."""
    file = folder / "image.mha"
    size, side = [scale * n for n in cells], 1 / scale
    if label.startswith("gyroid"):
        labels = eval(label)
    else:
        code = compile(label, label, "eval")
        at = [[(i + 0.5) * side for i in range(n)] for n in size]
        labels = bytes(int(eval(code, {"math": math, "x": x, "y": y, "z": z})) for z in at[2] for y in at[1] for x in at[0])
    header = (f"ObjectType = Image\nNDims = 3\nDimSize = {size[0]} {size[1]} {size[2]}\nElementSpacing = {side} {side} {side}\n"
              f"Offset = {side / 2} {side / 2} {side / 2}\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n")
    file.write_bytes(header.encode() + labels)
    return file.name
