#pragma once
/// Polynomials of several variables that are orthonormal in the measure of samples.

#include "study/sensitivity/sensitivity.hpp"

#include <Eigen/Core>

#include <vector>

namespace maille::studies {

/// Degrees of a product of polynomials, one an axis; all 0: the constant.
using Degrees = std::vector<int>;

/// Orthonormal polynomials of one axis at some positions: Legendre's over [-1, 1], Gram's on equally likely
/// levels.
/// @return a row a position, a column a degree from 0: as many as asked for, or as there are different levels
Eigen::MatrixXd polynomials_of(const SampledAxis& axis, const Eigen::VectorXd& at, int n_degrees);

/// All degrees whose sum is at most `total`, no axis above its own most; the constant first, by rising sums.
/// @return nothing where there are more than `most`
std::vector<Degrees> degrees_up_to(int total, const std::vector<int>& most_of_axis, std::size_t most);

/// The products at every sample. @param of_axes  polynomials_of each axis
Eigen::MatrixXd products_of(const std::vector<Eigen::MatrixXd>& of_axes, const std::vector<Degrees>& degrees);

} // namespace maille::studies
