#include "solvers/level_matrix.hpp"

#include <deal.II/lac/dynamic_sparsity_pattern.h>

#include <cmath>

namespace maille::fem_ref {

template<int dim>
LevelMatrix<dim>::LevelMatrix(const std::vector<float>& K, const std::vector<unsigned>& nodes,
                              std::vector<unsigned> fixed, std::size_t n_unknowns)
    : fixed_(std::move(fixed)) {
  const auto n_rows = static_cast<unsigned>(std::lround(std::sqrt(static_cast<double>(K.size()))));
  const unsigned per_cell = n_rows / dim;
  std::vector<bool> is_fixed(n_unknowns, false);
  for (const unsigned unknown : fixed_)
    is_fixed[unknown] = true;
  const auto unknown = [&](std::size_t cell, unsigned row) {
    return nodes[cell * per_cell + row / dim] + row % dim;
  };
  dealii::DynamicSparsityPattern pattern(static_cast<unsigned>(n_unknowns));
  std::vector<dealii::types::global_dof_index> columns;
  for (unsigned i = 0; i < n_unknowns; ++i)
    pattern.add(i, i);
  for (std::size_t cell = 0; cell < nodes.size() / per_cell; ++cell) {
    columns.clear();
    for (unsigned j = 0; j < n_rows; ++j)
      if (!is_fixed[unknown(cell, j)])
        columns.push_back(unknown(cell, j));
    for (unsigned i = 0; i < n_rows; ++i)
      if (!is_fixed[unknown(cell, i)])
        pattern.add_entries(unknown(cell, i), columns.begin(), columns.end());
  }
  pattern_.copy_from(pattern);
  matrix_.reinit(pattern_);
  for (std::size_t cell = 0; cell < nodes.size() / per_cell; ++cell)
    for (unsigned i = 0; i < n_rows; ++i)
      for (unsigned j = 0; j < n_rows && !is_fixed[unknown(cell, i)]; ++j)
        if (!is_fixed[unknown(cell, j)])
          matrix_.add(unknown(cell, i), unknown(cell, j), K[i * n_rows + j]);
}

template<int dim>
typename LevelMatrix<dim>::Vector LevelMatrix<dim>::inverse_diagonal() const {
  Vector diagonal(matrix_.m());
  for (unsigned i = 0; i < matrix_.m(); ++i)
    diagonal(i) = 1 / matrix_.diag_element(i); // of a fixed one: infinite until the next lines
  for (const unsigned unknown : fixed_)
    diagonal(unknown) = 0;
  return diagonal;
}

template<int dim>
std::int64_t LevelMatrix<dim>::bytes() const {
  return static_cast<std::int64_t>(pattern_.memory_consumption() + matrix_.memory_consumption());
}

template class LevelMatrix<2>;
template class LevelMatrix<3>;

} // namespace maille::fem_ref
