#pragma once
/// What a body has of every cell, and how it comes onto another grid.
///
/// An array of values that a Specimen gets is added here: bodies that are cropped, refined, turned or split
/// then carry it along.

#include "maille/scene/scene.hpp"

#include <array>
#include <cstdint>
#include <vector>

namespace maille {

/// Calls visit(values, value without matter) for the arrays of a body.
template<class Visit>
void for_each_cell_array(Specimen& body, const Visit& visit) {
  visit(body.material_id, no_material);
  visit(body.fibres, std::array<float, 3>{1, 0, 0});
  visit(body.label, std::int32_t{0});
  visit(body.tissue, 1.0F);
  visit(body.stiffness_ratio, 1.0F);
}

/// The values on a grid of `n_cells`; empty ones stay so.
/// @param source of a cell: the one whose value it takes, -1: none @param none that it has then
template<class T, class Source>
std::vector<T> carried(const std::vector<T>& values, std::int64_t n_cells, const T& none,
                       const Source& source) {
  std::vector<T> all;
  if (values.empty())
    return all;
  all.reserve(n_cells);
  for (std::int64_t cell = 0; cell < n_cells; ++cell) {
    const std::int64_t from = source(cell);
    all.push_back(from < 0 ? none : values[from]);
  }
  return all;
}

/// The same of a whole body that has got another grid.
template<class Source>
void carry_cells(Specimen& body, const Source& source) {
  for_each_cell_array(body, [&]<class T>(std::vector<T>& values, const T& none) {
    values = carried(values, body.grid.n_cells(), none, source);
  });
}

} // namespace maille
