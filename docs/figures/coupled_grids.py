#!/usr/bin/env python3
"""Draws docs/coupled_grids.svg: how the multigrid of `coupled` halves a body of any shape. No package is needed.

A cell of a coarser grid holds two cells an axis of the finer one. What lies in it and does not hang together at faces
becomes pieces of their own, so that a gap stays one on every grid. The rule is that of deform/src/elastic/masked, in 2D.
"""
import math
import pathlib

WIDTH, HEIGHT, GRIDS = 32, 16, 4
SIDE, GAP, TOP = 8.0, 26.0, 40.0
COLOURS = ["#7fa8d1", "#e0a458", "#8fbf88", "#c98bb0", "#b8b8b8"]


def is_matter(x, y):
    """Two struts that touch at their left ends and run beside each other, a cell apart, and a ring."""
    upper = abs(y - (9.5 + 2.2 * math.sin(x / 6))) < 1.6 and x < 23
    lower = abs(y - (5.0 + 2.2 * math.sin(x / 6))) < 1.6 and x < 23
    end = x < 3 and 4 < y < 11
    ring = 2.6 < math.hypot(x - 26, y - 8) < 5.4
    return upper or lower or end or ring


def finest():
    """{(x, y, piece): number of its cells}, every cell a piece, and which pieces share a face."""
    cells = {(x, y, 0) for x in range(WIDTH) for y in range(HEIGHT) if is_matter(x + 0.5, y + 0.5)}
    faces = {frozenset((a, b)) for a in cells for b in ((a[0] + 1, a[1], 0), (a[0], a[1] + 1, 0)) if b in cells}
    return {cell: 1 for cell in cells}, faces


def coarser(cells, faces):
    """The pieces of blocks of two cells an axis, joined within a block where they share a face."""
    leader = {cell: cell for cell in cells}

    def find(cell):
        while leader[cell] != cell:
            cell = leader[cell]
        return cell

    for a, b in (tuple(face) for face in sorted(faces, key=sorted)):
        if (a[0] // 2, a[1] // 2) == (b[0] // 2, b[1] // 2):
            leader[find(a)] = find(b)
    number, of_block, counts = {}, {}, {}
    for cell in sorted(cells):
        block, root = (cell[0] // 2, cell[1] // 2), find(cell)
        if root not in number:
            number[root] = (*block, of_block.setdefault(block, 0))
            of_block[block] += 1
        counts[number[root]] = counts.get(number[root], 0) + cells[cell]
    joined = {frozenset((number[find(a)], number[find(b)])) for a, b in (tuple(face) for face in faces)}
    return counts, {face for face in joined if len(face) == 2}


def draw():
    parts, left = [], 12.0
    cells, faces = finest()
    for grid in range(GRIDS):
        scale = 0.78 if grid else 1.0
        here = SIDE * scale * 2**grid
        split = {cell[:2] for cell in cells if cell[2] == 1}
        for x, y, piece in sorted(cells):
            n = 1 + max(p for (i, j, p) in cells if (i, j) == (x, y))
            high = here / n
            colour = COLOURS[0] if (x, y) not in split else COLOURS[1 + piece % 4]
            top = TOP + (HEIGHT / 2**grid - 1 - y) * here + (n - 1 - piece) * high
            parts.append(f'<rect x="{left + x * here:.1f}" y="{top:.1f}" width="{here - 0.8:.1f}" '
                         f'height="{high - 0.8:.1f}" fill="{colour}"/>')
        words = ["the body's grid", "second grid", "third grid", "fourth grid"][grid]
        steps = ["relaxed before and after", "corrected twice", "corrected twice", "corrected once"][grid]
        parts.append(f'<text x="{left:.0f}" y="16" class="name">{words}: {len(cells)} {"cells" if grid == 0 else "pieces"}</text>')
        parts.append(f'<text x="{left:.0f}" y="31" class="small">{steps}</text>')
        left += WIDTH * SIDE * scale + GAP
        cells, faces = coarser(cells, faces)
    return left, parts


def main():
    width, parts = draw()
    height = TOP + HEIGHT * SIDE + 8
    style = ".name{font:600 13px sans-serif;fill:#333}.small{font:12px sans-serif;fill:#555}"
    text = (f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" role="img" '
            f'aria-label="A body on four grids, split into pieces where it does not hang together">'
            f'<style>{style}</style><rect width="100%" height="100%" fill="white"/>' + "".join(parts) + "</svg>\n")
    (pathlib.Path(__file__).resolve().parent.parent / "coupled_grids.svg").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
