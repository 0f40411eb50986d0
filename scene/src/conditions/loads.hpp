#pragma once
/// Loads on a body: the same for those of files and of programs.

#include "conditions/asked.hpp"
#include "conditions/region.hpp"
#include "maille/materials/toml_reader.hpp"

namespace maille::reader {

/// A traction [Pa] on the outer faces of cells whose corners are all in the region; a fault of `where` where
/// there are none.
void add_traction(const Region& region, const Vec3& traction, const Asked& where, Scene& scene,
                  FaultList& faults);
/// A force [N], in 2D per metre of thickness, spread evenly over the area of the same faces.
void add_force(const Region& region, const Vec3& force, const Asked& where, Scene& scene, FaultList& faults);

/// The cells of matter in a region, or all, that `counts` says yes to.
template<class Counts>
std::vector<std::int64_t> cells_in(const std::optional<Region>& region, const Specimen& body,
                                   Counts&& counts) {
  std::vector<std::int64_t> cells;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell) && counts(cell) && (!region || region->contains_cell(body, cell)))
      cells.push_back(cell);
  return cells;
}

inline constexpr const char* wanted_cells = "at least one whole cell of matter";
inline constexpr const char* wanted_contraction = "a stress >= 0: fibres pull";

/// A stress [Pa] more that the fibres of cells pull with.
void add_contraction(const std::vector<std::int64_t>& cells, double stress, Scene& scene);

} // namespace maille::reader
