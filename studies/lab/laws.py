"""Closed forms of large strain: homogeneous states of the five laws, from their energies alone.

An energy is W(F), fibre along x, of one deformation gradient F. Nominal stress P = dW/dF is its central difference of fourth order, which shares no
derivative with the product's stress; stretches across that are free are those without nominal stress, by Newton's steps on differences. Good to
about 1e-9 of a modulus. Energies and names of parameters: docs/theory.md, section 4b.
"""
import math

IDENTITY = [[float(i == j) for j in range(3)] for i in range(3)]
STEP = 1e-3


def determinant(F):
    return sum(F[0][i] * (F[1][(i + 1) % 3] * F[2][(i + 2) % 3] - F[1][(i + 2) % 3] * F[2][(i + 1) % 3]) for i in range(3))


def invariants(F):
    """C, ln J, I1 and I2 without the change of volume, I4 and I5 likewise."""
    C = [[sum(F[k][i] * F[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    J = determinant(F)
    I1, squares = C[0][0] + C[1][1] + C[2][2], sum(C[i][j] ** 2 for i in range(3) for j in range(3))
    I4, I5 = C[0][0], sum(C[0][i] ** 2 for i in range(3))
    return C, math.log(J), J ** (-2 / 3) * I1, J ** (-4 / 3) * (I1 * I1 - squares) / 2, J ** (-2 / 3) * I4, J ** (-4 / 3) * I5


def neo_hookean(F, E, nu):
    mu, lam = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    C, L, *_ = invariants(F)
    return mu / 2 * (C[0][0] + C[1][1] + C[2][2] - 3) - mu * L + lam / 2 * L * L


def mooney_rivlin(F, c1, c2, k):
    _, L, I1, I2, *_ = invariants(F)
    return c1 * (I1 - 3) + c2 * (I2 - 3) + k / 2 * L * L


def guccione(F, C, bf, bt, bfs, k):
    of, L, *_ = invariants(F)
    E = [[(of[i][j] - (i == j)) / 2 for j in range(3)] for i in range(3)]
    Q = bf * E[0][0] ** 2 + bt * (E[1][1] ** 2 + E[2][2] ** 2 + 2 * E[1][2] ** 2) + 2 * bfs * (E[0][1] ** 2 + E[0][2] ** 2)
    return C / 2 * math.expm1(Q) + k / 2 * L * L


def holzapfel_gasser_ogden(F, c, k1, k2, kappa, k):
    _, L, I1, _, I4, _ = invariants(F)
    A = max(0, kappa * (I1 - 3) + (1 - 3 * kappa) * (I4 - 1))
    return c / 2 * (I1 - 3) + k1 / (2 * k2) * math.expm1(k2 * A * A) + k / 2 * (math.expm1(2 * L) / 2 - L)


def muscle(F, g1, g2, g3, p1, p2, Lofl, lam_max, smax, activation, k):
    """Of stretches of which r - 1 is within 0.4 and below lam_max."""
    _, L, I1, _, I4, I5 = invariants(F)
    r = math.sqrt(I4) / Lofl
    B2 = math.acosh(max(1, (I1 * I4 - I5) / (2 * math.sqrt(I4))))
    passive = p1 * (math.expm1(p2 * (r - 1)) / p2 - (r - 1)) if r > 1 else 0
    active = r - 1 - 4 / 3 * (r - 1) ** 3
    return g1 * (I5 / I4**2 - 1) + g2 * B2**2 + 9 / 16 * g3 * math.log(I4) ** 2 + smax * (passive + activation * active) + k / 2 * L * L


def nominal(energy, F, row, column):
    """dW/dF of one component [Pa]."""
    def at(by):
        return energy([[F[i][j] + (by if (i, j) == (row, column) else 0) for j in range(3)] for i in range(3)])
    return (8 * (at(STEP) - at(-STEP)) - (at(2 * STEP) - at(-2 * STEP))) / (12 * STEP)


def solved(residual, x):
    """x where residual(x) is 0: Newton's steps, the matrix by differences."""
    for _ in range(60):
        r = residual(x)
        if len(x) == 1:
            slope = (residual([x[0] + 1e-5])[0] - residual([x[0] - 1e-5])[0]) / 2e-5
            step = [-r[0] / slope]
        else:
            by = [[(p - m) / 2e-5 for p, m in zip(residual([v + 1e-5 * (i == j) for j, v in enumerate(x)]), residual([v - 1e-5 * (i == j) for j, v in enumerate(x)]))]
                  for i in range(2)]
            of = by[0][0] * by[1][1] - by[0][1] * by[1][0]
            step = [-(r[0] * by[1][1] - r[1] * by[1][0]) / of, -(r[1] * by[0][0] - r[0] * by[0][1]) / of]
        x = [v + max(-0.1, min(0.1, s)) for v, s in zip(x, step)]
        if max(map(abs, step)) < 1e-12:
            break
    return x


def force(law, way, stretch, parameters, size):
    """The size of the force on the moved faces of a block [N].
    @param size of the block [m]; @param way uniaxial, across (the fibre), biaxial, plane_strain, shear (by stretch - 1, of the face y+ along x)"""
    def energy(F):
        return globals()[law](F, **parameters)

    moved = {"uniaxial": [0], "across": [1], "biaxial": [0, 1], "plane_strain": [0], "shear": []}[way]
    free = {"uniaxial": [1, 2], "across": [0, 2], "biaxial": [2], "plane_strain": [1], "shear": []}[way]

    def gradient(across):
        F = [row[:] for row in IDENTITY]
        for axis in moved:
            F[axis][axis] = stretch
        for axis, value in zip(free, across):
            F[axis][axis] = value
        if way == "shear":
            F[0][1] = stretch - 1
        return F

    across = solved(lambda x: [nominal(energy, gradient(x), axis, axis) for axis in free], [stretch**-0.5 if len(free) == 2 else 1 / stretch] * len(free)) if free else []
    F = gradient(across)
    on = [(row, 1) for row in range(3)] if way == "shear" else [(axis, axis) for axis in moved]
    return math.hypot(*(nominal(energy, F, row, axis) * math.prod(size) / size[axis] for row, axis in on))
