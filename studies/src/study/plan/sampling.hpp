#pragma once
/// Sampling plans in the unit cube, for studies that are too large for a grid.

#include <cstdint>
#include <vector>

namespace maille::studies {

/// Points, with one coordinate in [0, 1) per dimension.
using UnitPoints = std::vector<std::vector<double>>;

/// @brief One random point in each of `n` slices of every dimension.
/// Source      McKay, Beckman and Conover 1979, section 2
/// Repeatable  numbers come directly from std::mt19937_64: distributions differ between standard libraries
UnitPoints latin_hypercube(int n, int dimensions, std::uint64_t seed);

/// @brief The first `n` points of Sobol's sequence, including the origin: omitting it destroys the balance of
///        2^m points.
/// Source  Sobol 1967, directions of Joe and Kuo 2008, by Boost.Random; on the first point Owen 2020
UnitPoints sobol_points(int n, int dimensions);

/// @brief Blocks of dimensions + 2 points for sensitivity estimates: A, B, then A with each coordinate in
///        turn from B. A and B are the halves of Sobol's points in twice the dimensions.
/// @param n  number of blocks, preferably a power of 2
/// Source  Saltelli 2002; Saltelli and others 2010, section 3
UnitPoints saltelli_points(int n, int dimensions);

} // namespace maille::studies
