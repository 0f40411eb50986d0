#pragma once
/// Moduli of the componentwise model: one per cell, link axis and component.

#include "maille/scene/scene.hpp"

#include <array>
#include <cstdint>

namespace maille::deform {

/// modulus[a][b] of a cell [Pa]: C_bb for b = a, the shear modulus C_(ab)(ab) otherwise, of the stiffness in
/// the object's frame, reduced to the scene's dimension. The model ignores couplings between strains.
class CellModuli {
public:
  using Table = std::array<std::array<double, 3>, 3>;

  /// Sets whether the materials' relaxed_weights apply; equal: every modulus is 1 Pa.
  enum class Weights { none, of_relaxed, equal };
  explicit CellModuli(const Scene& scene, Weights weights = Weights::none);

  /// True if every cell of the grid holds the same matter.
  bool is_homogeneous_box() const { return is_homogeneous_box_; }
  /// @pre the cell holds matter
  const Table& operator[](std::int64_t cell) const { return kinds_[kind(cell)]; }
  /// Moduli of the first cell of the body.
  const Table& first() const { return kinds_[first_kind_]; }

private:
  std::size_t kind(std::int64_t cell) const {
    if (!per_cell_.empty())
      return static_cast<std::size_t>(per_cell_[cell]);
    return specimen_->material(cell);
  }

  const Specimen* specimen_; ///< the scene must outlive this
  List<Table> kinds_;
  List<std::int32_t> per_cell_; ///< if cells have their own fibres or weights
  std::size_t first_kind_ = 0;
  bool is_homogeneous_box_ = true;
};

} // namespace maille::deform
