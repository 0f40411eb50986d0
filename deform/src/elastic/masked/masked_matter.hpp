#pragma once
/// The stiffness of a body of any shape in float32: coefficients of its cells, rows of its nodes, units.
///
/// Scheme    the operator applies cell by cell from a few coefficients a cell (MaskedOperator). Cells of one
///           kind share them through a table; where kinds are many or cells have weights, each has its own.
/// Notation  a slot is the place of a node in a field; slots follow the rows of nodes that touch the body
///           (MaskedRows). A field has one float32 for each component and slot: displacements times scale()
///           of their axis, forces over scale() and over unit(), so that entries are of order 1 for any
///           spacing and modulus.
/// Exact     it equals LatticeElasticity within float32 rounding. Springs and fixed components are not part
///           of it; see MaskedLevel.

#include "elastic/masked/coarsening/cell_complex.hpp"
#include "elastic/masked/masked_kernel.hpp"
#include "elastic/masked/piece_assembly.hpp"
#include "elastic/masked/slabs.hpp"
#include "elastic/model/lattice_elasticity.hpp"
#include "lattice/field_memory.hpp"
#include "parallel/thread_team.hpp"

#include <array>

namespace maille::deform {

using CellCoefficients = std::array<double, MaskedOperator::most_coefficients>;

/// Factors that turn the constants of a kind of matter into its coefficients.
/// @param scale per axis: spacing over the shortest spacing @param unit of forces over displacements [N/m]
CellCoefficients coefficient_factors(const Vec3& spacing, const Vec3& scale, double unit);
CellCoefficients coefficients_of(const LatticeElasticity::Kind& kind, const CellCoefficients& factors);
CellMatrix cell_matrix(const CellCoefficients& c);
using CellDiagonal = std::array<double, 24>;
CellDiagonal cell_diagonal(const CellCoefficients& c, bool bends); ///< of cell_matrix(c)

class MaskedMatter {
public:
  /// @param scene in 3D @param elasticity of slabs.layers(); both must outlive this
  MaskedMatter(const Scene& scene, const LatticeElasticity& elasticity, Slabs slabs, ThreadTeam& team);
  MaskedMatter(const MaskedMatter&) = delete; // the operator points into it
  MaskedMatter& operator=(const MaskedMatter&) = delete;

  const Scene& scene() const { return scene_; }
  const LatticeElasticity& elasticity() const { return elasticity_; }
  const Slabs& slabs() const { return slabs_; }
  const MaskedRows& rows() const { return rows_; }
  const MaskedOperator& cells() const { return operator_; }
  double unit() const { return unit_; } ///< of forces over displacements [N/m]
  const Vec3& scale() const { return scale_; }
  /// Factors by component from newtons to entries of fields, and from entries to metres, where an entry of 1
  /// is `size` times its unit.
  Vec3 force_factors(double size) const {
    const double all = 1 / (size * unit_);
    return {all / scale_[0], all / scale_[1], all / scale_[2]};
  }
  Vec3 displacement_factors(double size) const {
    return {size / scale_[0], size / scale_[1], size / scale_[2]};
  }
  CellCoefficients coefficients_of(const LatticeElasticity::Kind& kind) const {
    return deform::coefficients_of(kind, factors_);
  }
  /// Slots of a component, rounded up to whole lines.
  static constexpr std::int64_t stride_of(std::int64_t n_slots) { return (n_slots + 15) / 16 * 16; }
  /// Slot of a node, or -1 where not all layers of the body around it are stored.
  std::int32_t slot_if_known(std::int64_t node) const;
  /// Reads the constants of matter anew; kinds of matter, where they are, and the unit stay.
  void renew(ThreadTeam& team) { set_coefficients(team); }
  /// Sets the inverse of the diagonal of the operator and of `elasticity`'s springs; 0 outside the body.
  void invert_diagonal(AlignedArray<float>& inverse, ThreadTeam& team) const;
  /// Cells of matter, in the grid's order; vertices are slots.
  CellComplex complex(ThreadTeam& team) const;

private:
  bool has_table() const;
  void choose_unit();
  template<class Work>
  void for_layers(ThreadTeam& team, const Work& work) const;
  template<class Visit>
  void for_each_cell(const CellRun& run, const Visit& visit) const;
  void set_coefficients(ThreadTeam& team);
  void set_table(ThreadTeam& team);
  void set_own_coefficients(ThreadTeam& team);
  void set_kinds_of_blocks(ThreadTeam& team);

  const Scene& scene_;
  const LatticeElasticity& elasticity_;
  Slabs slabs_;
  MaskedRows rows_;
  double unit_ = 1;
  Vec3 scale_{1, 1, 1};
  CellCoefficients factors_{}; ///< of coefficients
  MaskedOperator operator_;
  AlignedArray<float> coefficients_;
  AlignedArray<std::uint8_t> kind_, block_kind_;
};

} // namespace maille::deform
