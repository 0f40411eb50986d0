"""Variance-based sensitivity: which share of a result's variance is whose parameter's, from samples that there are.

A parameter's first-order index is the share of the variance that it makes alone, its total index that in which it
takes part (Sobol 1993; Homma and Saltelli 1996). Parameters are independent: uniform over their range (its
logarithm where that is what is varied), or equally likely among the values of a list.

* ``by_grid``: the analysis of variance of a whole table, exact for values that are equally likely.
* ``by_pairs``: Saltelli's blocks of points. First order by Saltelli and others 2010, table 2 (b), about the mean, total
  by Jansen 1999. No assumption of smoothness. Intervals: percentiles of 1000 bootstraps of the blocks.
* ``by_chaos``: samples that lie anyhow. Orthonormal polynomials of rising total degree (Legendre's; Hermite's; Gram's on levels),
  taken one by one by orthogonal matching pursuit, as many and of the degree that five-fold cross-validation asks
  for; squares of coefficients are the indices (Sudret 2008; Blatman and Sudret 2011). ``unexplained`` is the error of
  cross-validation. Intervals: 400 wild bootstraps of the coefficients (Wu 1986), widened by it.

Repeatable: all draws are those of the 64-bit Mersenne twister, whatever the version of numpy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import islice
from typing import Any, Dict, Iterator, List, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt
from numpy.polynomial import hermite_e, legendre
from scipy.linalg import qr, solve_triangular

HIGHEST_DEGREE = 20
MOST_UNEXPLAINED = 1 / 3
FEWEST_BLOCKS = 10

Array = npt.NDArray[Any]
# Positions in [-1, 1], equally likely; None: anywhere there alike; "normal": a standard normal variable.
Axis = Union[None, str, Sequence[float]]
Degrees = Tuple[int, ...]  # of a product of polynomials, one an axis


@dataclass
class Sensitivity:
    """Indices of every parameter, or why there are none."""

    n_axes: int
    estimator: str = ""
    samples: int = 0  #: with a finite value
    left_out: int = 0
    mean: float = 0.0
    standard_deviation: float = 0.0
    unexplained: float = 0.0  #: share of the variance that the estimator's own model leaves, on samples it has not seen
    undetermined: str = ""  #: why there are no indices; empty where there are
    first: Array = field(default_factory=lambda: np.empty((0, 3)))  #: value, low, high: a row a parameter
    total: Array = field(default_factory=lambda: np.empty((0, 3)))

    def as_json(self, parameters: Sequence[str]) -> Dict[str, Any]:
        """The entry that ``maille study --json`` has."""
        names = ("estimator", "samples", "left_out", "mean", "standard_deviation", "unexplained", "undetermined")
        rows = []
        for i, parameter in enumerate(parameters):
            row: Dict[str, Any] = {"parameter": parameter}
            for key, indices in (("first", self.first), ("total", self.total)):
                for end, ending in enumerate(("", "_low", "_high")):
                    row[key + ending] = None if self.undetermined else float(indices[i, end])
            rows.append(row)
        return {**{name: getattr(self, name) for name in names}, "parameters": rows}


class Lot:
    """The 64-bit Mersenne twister (Matsumoto and Nishimura 2000; std::mt19937_64), which numpy lacks."""

    def __init__(self, seed: int = 1) -> None:
        state = [seed]
        for i in range(1, 312):
            state.append((6364136223846793005 * (state[-1] ^ (state[-1] >> 62)) + i) % 2**64)
        self._state, self._left = np.array(state, np.uint64), np.empty(0, np.uint64)

    def __call__(self, n: int) -> Array:
        """The next n numbers of 64 bits."""
        blocks = [self._left] + [self._next() for _ in range(-(-(n - len(self._left)) // 312))]
        numbers = np.concatenate(blocks)
        self._left = numbers[n:]
        return numbers[:n]

    def shuffled(self, n: int) -> Array:
        order = np.arange(n)
        for i, drawn in zip(range(n, 1, -1), self(n - 1)):
            place = int(drawn) % i
            order[i - 1], order[place] = order[place], order[i - 1]
        return order

    def _next(self) -> Any:
        def word(number: int) -> np.uint64:
            return np.uint64(number)

        def mixed(high: Array, low: Array) -> Any:
            both = (high & word(0xFFFFFFFF80000000)) | (low & word(0x7FFFFFFF))
            return (both >> word(1)) ^ ((both & word(1)) * word(0xB5026F5AA96619E9))

        s = self._state
        s[:156] = s[156:] ^ mixed(s[:156], s[1:157])
        s[156:311] = s[:155] ^ mixed(s[156:311], s[157:])
        s[311:] = s[155:156] ^ mixed(s[311:], s[:1])
        y = s ^ ((s >> word(29)) & word(0x5555555555555555))
        y ^= (y << word(17)) & word(0x71D67FFFEDA60000)
        y ^= (y << word(37)) & word(0xFFF7EEE000000000)
        return y ^ (y >> word(43))


def _blank(n_axes: int, values: Array, estimator: str) -> Sensitivity:
    known = values[np.isfinite(values)]
    found = Sensitivity(n_axes, estimator, len(known), len(values) - len(known))
    if len(known) == 0:
        found.undetermined = "no sample has a value"
        return found
    found.mean, found.standard_deviation = float(np.mean(known)), float(np.std(known))
    if not found.standard_deviation > 1e-12 * np.max(np.abs(known)):
        found.undetermined = "the value is the same in all samples"
    return found


def _set_indices(found: Sensitivity, indices: Array, bootstraps: Array) -> None:
    """@param indices  first-order ones, then total ones @param bootstraps  the same, a row a draw"""
    spread = np.sort(np.vstack([indices[np.newaxis], bootstraps]), axis=0)
    ends = [spread[math.floor(share * (len(spread) - 1) + 0.5)] for share in (0.025, 0.975)]
    low, high = np.minimum(indices, ends[0]), np.maximum(indices, ends[1])
    if found.unexplained > 0:  # no parameter's for certain, therefore in every interval
        low = np.minimum(low, np.maximum(0, low - found.unexplained))
        high = np.maximum(high, np.minimum(1, high + found.unexplained))
    both = np.column_stack([indices, low, high])
    found.first, found.total = both[: found.n_axes], both[found.n_axes :]


def by_grid(counts: Sequence[int], values: npt.ArrayLike) -> Sensitivity:
    """From every combination of values, the last axis fastest. Intervals are the indices themselves.

    @param values  prod(counts) numbers; undetermined where one is not finite
    """
    flat = np.asarray(values, float)
    found = _blank(len(counts), flat, "variances of the grid, values equally likely")
    if not found.undetermined and found.left_out:
        found.undetermined = f"{found.left_out} of {len(flat)} values of the grid are missing"
    if found.undetermined:
        return found
    table, axes = (flat - found.mean).reshape(counts), range(len(counts))
    variance = found.standard_deviation**2
    alone = [np.mean(np.mean(table, axis=tuple(a for a in axes if a != axis)) ** 2) / variance for axis in axes]
    others = [max(0.0, 1 - np.mean(np.mean(table, axis=axis) ** 2) / variance) for axis in axes]
    _set_indices(found, np.array(alone + others), np.empty((0, 2 * len(counts))))
    return found


def by_pairs(n_parameters: int, values: npt.ArrayLike) -> Sensitivity:
    """From pairs of points A and B, and points that are A but for one coordinate, which is B's.

    @param values  of blocks A, B, AB_1, ..., AB_d; a block with a value that is not finite is left out whole
    """
    d = n_parameters
    flat = np.asarray(values, float)
    if len(flat) % (d + 2):
        raise ValueError(f"by_pairs: {len(flat)} values are no blocks of {d + 2}")
    blocks = flat.reshape(-1, d + 2)
    is_whole = np.isfinite(blocks).all(axis=1)
    used = np.where(is_whole[:, np.newaxis], blocks, np.nan).ravel()
    blocks = blocks[is_whole]
    n = len(blocks)
    found = _blank(d, used, f"{n} pairs of points")
    if not found.undetermined and n < FEWEST_BLOCKS:
        found.undetermined = f"{n} whole blocks of samples, at least {FEWEST_BLOCKS} are needed"
    if found.undetermined:
        return found
    # Sums over blocks drawn any number of times are products with their shares. About the mean, which rounds least.
    a, b = (blocks[:, :2] - np.mean(blocks[:, :2])).T
    change = blocks[:, 2:] - blocks[:, :1]
    parts = np.column_stack([(a + b) / 2, (a * a + b * b) / 2, change, b[:, np.newaxis] * change, change**2 / 2])

    def indices(shares: Array) -> Any:
        sums = shares @ parts
        mean, changes, products, squares = sums[0], sums[2 : d + 2], sums[d + 2 : 2 * d + 2], sums[2 * d + 2 :]
        variance = sums[1] - mean**2
        return np.concatenate([products - mean * changes, squares]) / variance if variance > 0 else np.zeros(2 * d)

    lot = Lot()
    draws = [indices(np.bincount((lot(n) % np.uint64(n)).astype(int), minlength=n) / n) for _ in range(1000)]
    _set_indices(found, indices(np.full(n, 1 / n)), np.array(draws))
    return found


def _polynomials(at: Array, levels: Axis, n_degrees: int) -> Any:
    """Orthonormal ones at positions, a column a degree from 0: as many as asked for, or as there are different levels."""
    vander: Any = legendre.legvander
    if levels == "normal":
        hermite: Any = hermite_e.hermevander
        return hermite(at, n_degrees - 1) / np.sqrt([float(math.factorial(n)) for n in range(n_degrees)])
    if levels is None or isinstance(levels, str):
        return vander(at, n_degrees - 1) * np.sqrt(2 * np.arange(n_degrees) + 1)
    n = min(n_degrees, len(set(levels)))
    triangle = qr(vander(np.asarray(levels), n - 1) / math.sqrt(len(levels)), mode="r")[0][:n]
    triangle *= np.sign(np.diag(triangle))[:, np.newaxis]
    return solve_triangular(triangle.T, vander(at, n - 1).T, lower=True).T


def _degrees_of(total: int, most: Sequence[int]) -> Iterator[Degrees]:
    """All degrees with that sum, no axis above its own most."""
    if total > sum(most):
        return
    if len(most) == 1:
        yield (total,)
        return
    for degree in range(min(total, most[0]), -1, -1):
        for rest in _degrees_of(total - degree, most[1:]):
            yield (degree, *rest)


def _products(of_axes: Sequence[Array], degrees: Sequence[Degrees]) -> Array:
    """A row a sample, a column a product."""
    columns = np.array(degrees)
    result = np.ones((len(of_axes[0]), len(degrees)))
    for axis, polynomials in enumerate(of_axes):
        result *= polynomials[:, columns[:, axis]]
    return result


class _Pursuit:
    """Orthogonal matching pursuits side by side, each on the samples that it sees: takes one polynomial after another, that
    which is nearest to the rest of the values.

    A direction is a polynomial less what those before it span. Products of directions and polynomials suffice for the
    gains of the next step: a step costs one product of matrices.
    """

    def __init__(self, products: Array, values: Array, seen: Array) -> None:
        """@param seen  (n_pursuits, n_samples), 0 or 1"""
        self.products, self.seen = products, seen
        self.rest = np.tile(values, (len(seen), 1))
        self.gains: Any = (seen * values) @ products
        self.sizes: Any = seen @ products**2
        self.least_sizes = 1e-8 * self.sizes
        self.directions, self.shares = np.empty((0, *seen.shape)), np.empty((0, *self.sizes.shape))
        self.taken: List[Array] = []  # a polynomial a pursuit; -1: none is left

    def take_next(self) -> None:
        each = np.arange(len(self.seen))
        following = np.zeros(len(each), int)  # the constant first, whatever it explains
        if self.taken:
            usable = self.sizes > self.least_sizes
            gains = np.where(usable, self.gains**2 / np.where(usable, self.sizes, 1), -1)
            following = np.where(gains.max(axis=1) > 0, gains.argmax(axis=1), -1)
        direction = self.products.T[following]
        direction = direction - np.einsum("kp,kpn->pn", self.shares[:, each, following], self.directions)
        again = np.einsum("kpn,pn->kp", self.directions, self.seen * direction)  # against rounding
        direction -= np.einsum("kp,kpn->pn", again, self.directions)
        size = np.linalg.norm(self.seen * direction, axis=1)
        direction *= np.where((following >= 0) & (size > 0), 1 / np.where(size > 0, size, 1), 0)[:, np.newaxis]
        shares = (self.seen * direction) @ self.products
        step = np.sum(self.seen * direction * self.rest, axis=1)[:, np.newaxis]
        self.rest -= step * direction
        self.gains -= step * shares
        self.sizes -= shares**2
        self.sizes[each, following] = 0  # a direction is taken once
        self.directions = np.concatenate([self.directions, direction[np.newaxis]])
        self.shares = np.concatenate([self.shares, shares[np.newaxis]])
        self.taken.append(following)


def _validation(products: Array, values: Array, order: Array, enough: float) -> Tuple[int, float]:
    """Five pursuits, each without a fifth of the samples, until errors there no longer fall. @return terms, mean square"""
    n = len(values)
    seen = np.ones((5, n))
    for fold in range(5):
        seen[fold, order[n * fold // 5 : n * (fold + 1) // 5]] = 0
    pursuits = _Pursuit(products, values, seen)
    best, least, k = 1, math.inf, 1
    while k <= min(n // 2, products.shape[1], 300, best + 10 + best // 4) and least > enough:
        pursuits.take_next()
        error = float(np.sum((1 - seen) * pursuits.rest**2)) / n
        if error < least:
            best, least = k, error
        k += 1
    return best, least


def _best_model(of_axes: Sequence[Array], values: Array, order: Array) -> Tuple[List[Degrees], float]:
    """The degree and number of terms of least error, among those that the samples allow."""
    n, most = len(values), [polynomials.shape[1] - 1 for polynomials in of_axes]
    most_terms = int(max(len(of_axes) + 1, min(4 * n, 1000, 1e6 / n)))
    enough = 1e-10 * float(np.var(values))
    candidates: List[Degrees] = list(_degrees_of(0, most))
    chosen: List[Degrees] = []
    n_terms, least, last_better = 1, math.inf, 1
    for degree in range(1, min(HIGHEST_DEGREE, sum(most)) + 1):
        candidates += islice(_degrees_of(degree, most), most_terms + 1 - len(candidates))
        if len(candidates) > most_terms or degree > last_better + 3 or least <= enough:  # even and odd parts come in turns
            break
        terms, error = _validation(_products(of_axes, candidates), values, order, enough)
        if error < 0.99 * least:
            n_terms, least, last_better, chosen = terms, error, degree, list(candidates)
    if not chosen:
        return [], least
    pursuit = _Pursuit(_products(of_axes, chosen), values, np.ones((1, n)))
    for _ in range(n_terms):
        pursuit.take_next()
    return [chosen[int(i)] for (i,) in pursuit.taken if i >= 0], least


def by_chaos(points: npt.ArrayLike, values: npt.ArrayLike, levels: Optional[Sequence[Axis]] = None) -> Sensitivity:
    """From samples that lie anyhow: a Latin hypercube, Sobol's points, a grid with gaps.

    @param points  (n, d) in [-1, 1] @param values  n numbers; those that are not finite are left out and counted
    @param levels  of each axis: None, or the values of a list, each as often as it is listed; "normal": points there are
                   numbers of deviations from the middle
    Undetermined  by fewer than 10 samples or 3 a parameter, and where more than a third of the variance is unexplained
    Cost  samples x polynomials tried x polynomials taken; with 1000 samples some seconds
    """
    at, y = np.asarray(points, float), np.asarray(values, float)
    d = at.shape[1]
    found = _blank(d, y, "polynomial chaos")
    if not found.undetermined and found.samples < max(10, 3 * d):
        found.undetermined = f"{found.samples} samples with a value, at least {max(10, 3 * d)} are needed"
    if found.undetermined:
        return found
    at, y = at[np.isfinite(y)], y[np.isfinite(y)]
    of_axes = [_polynomials(at[:, axis], levels[axis] if levels else None, HIGHEST_DEGREE + 2) for axis in range(d)]
    terms, error = _best_model(of_axes, y, Lot().shuffled(len(y)))
    found.unexplained = min(1.0, error / found.standard_deviation**2)
    if len(terms) < 2 or found.unexplained > MOST_UNEXPLAINED:
        found.undetermined = f"polynomials explain {100 * (1 - found.unexplained):.0f} % of the variance: more samples are needed"
        return found
    products = _products(of_axes, terms)
    basis, triangle = qr(products, mode="economic")
    inverse = solve_triangular(triangle, basis.T)
    coefficients = inverse @ y
    left_out = (y - products @ coefficients) / np.maximum(1 - np.sum(basis**2, axis=1), 1e-6)
    has = np.array(terms) > 0
    is_alone = has & (np.sum(has, axis=1) == 1)[:, np.newaxis]
    masks = np.column_stack([is_alone, has]).astype(float)

    def indices(of_terms: Array) -> Any:
        squares = of_terms**2 * has.any(axis=1)
        everything = np.sum(squares, axis=-1, keepdims=True)
        return squares @ masks / np.where(everything > 0, everything, 1)

    signs = np.where(Lot()(400 * len(y)).reshape(400, -1) >> np.uint64(63), 1, -1)
    found.estimator += f", {len(terms)} terms"
    _set_indices(found, indices(coefficients), indices(coefficients + (signs * left_out) @ inverse.T))
    return found
