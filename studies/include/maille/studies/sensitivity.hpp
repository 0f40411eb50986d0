#pragma once
/// Variance-based sensitivity: which share of a result's variance is whose, from samples that there are.
///
/// A parameter's first-order index is the share of the variance that it makes alone, its total index that in
/// which it takes part (Sobol 1993; Homma and Saltelli 1996). Parameters are independent: uniform over their
/// range (its logarithm where that is what is varied), or equally likely among the values of a list.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// An estimate [1] and its interval of 95 %. Nothing where the samples do not tell.
struct SobolIndex {
  std::optional<double> value, low, high;
};

struct Sensitivity {
  std::vector<SobolIndex> first, total; ///< one a parameter
  std::string estimator;                ///< in words
  int n_used = 0, n_left_out = 0;       ///< samples; left out: without a finite value
  double mean = 0, deviation = 0;       ///< of the values that are used
  /// Share of the variance that the estimator's own model leaves, told on samples that it had not seen [1];
  /// no parameter's for certain, therefore in every interval.
  double unexplained = 0;
  std::string undetermined; ///< why there are no indices; empty where there are
};

/// Where a parameter's samples lie.
struct SampledAxis {
  /// Positions in [-1, 1], equally likely, as often as they are listed; empty: anywhere in [-1, 1] alike.
  std::vector<double> levels;
};

/// By position on every axis; a value that is not finite, or not there, is left out and counted.
struct SampledValues {
  std::vector<SampledAxis> axes;
  std::vector<std::vector<double>> points; ///< sample by axis, in [-1, 1]
  std::vector<std::optional<double>> values;
};

/// @brief From samples that lie anyhow (a Latin hypercube, Sobol's points, a grid with gaps): polynomial
///        chaos, whose coefficients give the indices at once.
///
/// Orthonormal polynomials of rising total degree, of which those are taken one by one that are nearest to
/// what is left (orthogonal matching pursuit), as many and of the degree that five-fold cross-validation asks
/// for.
/// `unexplained` is its error; intervals are those of 400 wild bootstraps of the coefficients, widened by it.
/// Nothing is determined by fewer than 10 samples or 3 a parameter, nor where more than a third of the
/// variance is unexplained.
/// Source  Sudret 2008; Blatman and Sudret 2011 (choice of terms); Wu 1986 (bootstrap)
/// Cost    samples x polynomials tried x polynomials taken; with 1000 samples below a second
/// Repeatable  the same numbers everywhere, to rounding
Sensitivity sobol_by_chaos(const SampledValues& samples);

/// @brief From every combination of values, the last axis fastest: the analysis of variance of the table,
///        exact for values that are equally likely. Intervals are the indices themselves.
/// @return undetermined where a value is missing
/// @pre values.size() is the product of `counts`
Sensitivity sobol_by_grid(const std::vector<int>& counts, const std::vector<std::optional<double>>& values);

/// @brief From pairs of points A and B, and points that are A but for one coordinate, which is B's: blocks of
///        A, B, AB_1, ..., AB_d, as saltelli_points has them. Makes no assumption of smoothness.
///
/// First order by Saltelli and others 2010, table 2 (b), about the mean, total by Jansen 1999. Intervals are
/// percentiles of 1000 bootstraps of the blocks. A block with a value missing is left out whole.
/// @pre values.size() is a multiple of n_parameters + 2
Sensitivity sobol_by_pairs(int n_parameters, const std::vector<std::optional<double>>& values);

} // namespace maille::studies
