#include "discretization/cell_operator.hpp"

#include <array>
#include <cmath>
#include <stdexcept>

namespace maille::fem_ref {
namespace {

/// Unknowns of the largest element: Q2 in 3D.
constexpr int largest_element = 81;

} // namespace

template<int dim, class Number>
CellOperator<dim, Number>::CellOperator(std::vector<Number> K, std::vector<unsigned> nodes,
                                        std::vector<unsigned> fixed, std::size_t n_unknowns)
    : n_rows_(static_cast<int>(std::lround(std::sqrt(static_cast<double>(K.size()))))), K_(std::move(K)),
      nodes_(std::move(nodes)), fixed_(std::move(fixed)), n_(n_unknowns) {}

template<int dim, class Number>
void CellOperator<dim, Number>::vmult(Vector& to, const Vector& from) const {
  alignas(64) std::array<Number, static_cast<std::size_t>(largest_element * cells_per_batch)> x, y;
  x.fill(0); // lanes beyond the last cell
  to = Number(0);
  Number* const sum = to.begin();
  const Number* const value = from.begin();
  const std::size_t per_cell = static_cast<std::size_t>(n_rows_) / dim;
  const std::size_t n_cells = nodes_.size() / per_cell;
  for (std::size_t first = 0; first < n_cells; first += cells_per_batch) {
    const std::size_t n = std::min<std::size_t>(cells_per_batch, n_cells - first);
    for (std::size_t lane = 0; lane < n; ++lane)
      for (std::size_t k = 0; k < per_cell; ++k) {
        const Number* at = value + nodes_[(first + lane) * per_cell + k];
        for (std::size_t c = 0; c < dim; ++c)
          x[(dim * k + c) * cells_per_batch + lane] = at[c];
      }
    multiply(K_.data(), n_rows_, x.data(), y.data());
    for (std::size_t lane = 0; lane < n; ++lane)
      for (std::size_t k = 0; k < per_cell; ++k) {
        Number* at = sum + nodes_[(first + lane) * per_cell + k];
        for (std::size_t c = 0; c < dim; ++c)
          at[c] += y[(dim * k + c) * cells_per_batch + lane];
      }
  }
  for (const unsigned unknown : fixed_)
    sum[unknown] = 0;
}

template<int dim, class Number>
Number CellOperator<dim, Number>::el(std::size_t, std::size_t) const {
  throw std::logic_error("a cell operator holds no entries");
}

template<int dim, class Number>
typename CellOperator<dim, Number>::Vector CellOperator<dim, Number>::inverse_diagonal() const {
  Vector diagonal;
  initialize_dof_vector(diagonal);
  const std::size_t per_cell = static_cast<std::size_t>(n_rows_) / dim;
  for (std::size_t i = 0; i < nodes_.size(); ++i)
    for (std::size_t c = 0; c < dim; ++c) {
      const std::size_t row = dim * (i % per_cell) + c;
      diagonal.begin()[nodes_[i] + c] += K_[row * static_cast<std::size_t>(n_rows_ + 1)];
    }
  for (std::size_t i = 0; i < n_; ++i)
    diagonal.begin()[i] = 1 / diagonal.begin()[i];
  for (const unsigned unknown : fixed_)
    diagonal.begin()[unknown] = 0;
  return diagonal;
}

template<int dim, class Number>
std::int64_t CellOperator<dim, Number>::bytes() const {
  return static_cast<std::int64_t>(K_.size() * sizeof(Number) +
                                   (nodes_.size() + fixed_.size()) * sizeof(unsigned));
}

template class CellOperator<2, float>;
template class CellOperator<2, double>;
template class CellOperator<3, float>;
template class CellOperator<3, double>;

} // namespace maille::fem_ref
