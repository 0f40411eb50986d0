#pragma once
/// Plans in the unit cube for studies that cannot afford a grid.

#include <cstdint>
#include <vector>

namespace maille::studies {

/// Points, each with one coordinate in [0, 1) a dimension.
using UnitPoints = std::vector<std::vector<double>>;

/// @brief One point in each of `n` slices of every dimension, at random within them.
/// Source      McKay, Beckman and Conover 1979, section 2
/// Repeatable  numbers are drawn from std::mt19937_64 by hand: library distributions differ from one another
UnitPoints latin_hypercube(int n, int dimensions, std::uint64_t seed);

/// @brief The first `n` points of Sobol's sequence, the origin included: dropping it spoils the balance of
///        2^m points.
/// Source  Sobol 1967, directions of Joe and Kuo 2008, by Boost.Random; on the first point Owen 2020
UnitPoints sobol_points(int n, int dimensions);

/// @brief Blocks of dimensions + 2 points for estimates of sensitivity: A, B, then A with one coordinate
///        after another from B. A and B are the halves of Sobol's points in twice as many dimensions.
/// @param n  blocks, best a power of 2
/// Source  Saltelli 2002; Saltelli and others 2010, section 3
UnitPoints saltelli_points(int n, int dimensions);

} // namespace maille::studies
