#pragma once
/// Finest multigrid level of a body of any shape: its fields, fixed components, and relaxation.
///
/// The operator is that of MaskedMatter, plus springs as sparse rows. inverse() is the inverse of its
/// diagonal and doubles as the mask: 0 where a component is fixed or a slot has no matter.
///
/// A pass goes over planes of nodes, and finishes a plane while it is in the cache. Ranks share a body by
/// slabs of planes: a rank's fields are valid in its own planes; exchange_borders() copies the planes next to
/// them from their owners.

#include "elastic/krylov/field_map.hpp"
#include "elastic/masked/block_matrix.hpp"
#include "elastic/masked/coarse_operator.hpp"
#include "elastic/masked/masked_matter.hpp"
#include "lattice/field_memory.hpp"
#include "maille/scene/answer.hpp"
#include "parallel/thread_team.hpp"

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

namespace maille::deform {

class MaskedLevel {
public:
  /// @param scene in 3D; must outlive this @param prescribed components that are fixed
  MaskedLevel(const Scene& scene, const LatticeElasticity& elasticity,
              const std::vector<Prescribed>& prescribed, ThreadTeam& team)
      : MaskedLevel(scene, elasticity, prescribed, team, Slabs(scene.specimen, nullptr)) {}
  /// A rank's part. @param elasticity of slabs.layers() @pre no springs where slabs are shared
  MaskedLevel(const Scene& scene, const LatticeElasticity& elasticity,
              const std::vector<Prescribed>& prescribed, ThreadTeam& team, const Slabs& slabs);

  const MaskedMatter& matter() const { return matter_; }
  const Slabs& slabs() const { return matter_.slabs(); }
  const MaskedRows& rows() const { return matter_.rows(); }
  std::int64_t component_stride() const { return matter_.cells().component_stride; }
  /// An empty field, with the padding that loops may read.
  AlignedArray<float> field() const { return AlignedArray<float>(field_size() + 16); }
  /// Copies the planes next to its own from their owners. @param above planes above its own
  void exchange_borders(AlignedArray<float>& field, int above = 1) const {
    slabs().exchange_borders(rows(), component_stride(), field.data(), above);
  }
  /// Inverse of the diagonal; 0 where a component is fixed, or outside the body.
  const float* inverse() const { return inverse_.data(); }
  /// Fixes these components in place of the present ones.
  void set_fixed(const std::vector<Prescribed>& prescribed);
  /// Reads the constants of matter anew. See MaskedMatter::renew.
  void renew_matter(ThreadTeam& team);
  /// forces = A displacement, of fixed components too. Same bits for any number of threads.
  void apply(const float* displacement, float* forces, ThreadTeam& team) const;
  /// Ap = A p where components are free, 0 elsewhere. @return p . Ap
  double apply_and_dot(const float* p, float* Ap, ThreadTeam& team);
  /// u += weight (f - A u) / diagonal, in the memory of r. The second one returns u . f.
  void relax(float weight, ThreadTeam& team);
  double relax_and_dot(float weight, ThreadTeam& team);
  /// r = f - A u where components are free, 0 elsewhere.
  void find_residual(ThreadTeam& team);
  /// f = noise_entries(), the same on any number of ranks.
  void set_noise(ThreadTeam& team);
  double dot(const float* a, const float* b, ThreadTeam& team);
  /// Stiffness of the springs to the ground, by slots; no blocks without springs.
  BlockMatrix springs_as_matrix() const;

  AlignedArray<float> u, f, r;
  /// Makes the fields, all 0, or frees them while coarser grids are built.
  void make_fields(bool does);

  /// Calls work(first entry, how many) for parts of the entries of a field.
  template<class Work>
  void for_each_part(ThreadTeam& team, Work&& work) const {
    for_parts(field_size(), team, [&](std::size_t first, std::size_t end, std::size_t) {
      work(static_cast<std::int64_t>(first), static_cast<std::int64_t>(end - first));
    });
  }
  /// Calls visit(FieldRow) for the rows of nodes in its own planes and in those next to them. See FieldRow.
  template<class Visit>
  void for_each_row(ThreadTeam& team, const Visit& visit) const;

private:
  std::size_t field_size() const { return static_cast<std::size_t>(3 * component_stride()); }
  double sum_over_planes() { return slabs().total(sums_); }
  template<class Finish>
  void apply_by_planes(const float* displacement, float* forces, ThreadTeam& team,
                       const Finish& finish) const;
  template<class Work>
  void for_components(int plane, const Work& work) const;
  void set_springs();

  /// In the units of fields, column after column; 0 where components are fixed.
  struct SlotSpring {
    std::int32_t slot = 0;
    std::array<float, 9> block{};
  };

  MaskedMatter matter_;
  List<SlotSpring> springs_;
  AlignedArray<float> inverse_;
  std::vector<double> sums_; ///< of its own planes of nodes
  /// Entries of inverse_ before components were fixed.
  std::vector<std::pair<std::size_t, float>> fixed_;
};

template<class Visit>
void MaskedLevel::for_each_row(ThreadTeam& team, const Visit& visit) const {
  const Grid& grid = matter_.scene().specimen.grid;
  const PlaneRange own = slabs().own();
  const auto all = rows().rows_of_planes({own.first - 1, own.end + 1});
  team.run((static_cast<int>(all.size()) + rows_per_item - 1) / rows_per_item, [&](int item, int) {
    const auto first = static_cast<std::size_t>(item * rows_per_item);
    for (const NodeRow& row : all.subspan(first, std::min<std::size_t>(rows_per_item, all.size() - first)))
      for (std::int64_t c = 0; c < 3; ++c) {
        const std::int64_t place = c * component_stride() + row.slot;
        visit(FieldRow{static_cast<std::size_t>(c), place, grid.node(row.first), row.nodes,
                       inverse_.data() + place});
      }
  });
}

/// The operator of the first coarser grid, between the functions of `coarsened`; 0 where components are
/// fixed. @param fine what level.matter().complex() returned @param by_patterns where most pieces are alike
CoarseOperator galerkin_product(const MaskedLevel& level, const CellComplex& fine, const Coarsened& coarsened,
                                bool by_patterns, ThreadTeam& team);
/// The same where ranks share it: the rank's rows. @param cells of all ranks, on the first one @param whole
/// receives the operator of all ranks, on the first one
CoarseOperator galerkin_product(const MaskedLevel& level, const CellComplex& fine, const Coarsened& coarsened,
                                const SharedPieces* shared, bool by_patterns, ThreadTeam& team,
                                const List<ComplexCell>& cells, CoarseOperator* whole);

/// The operator of the next coarser grid, as blocks. @param fine what A's grid was `coarsened` of
/// @param P_transposed of its interpolation
CoarseOperator galerkin_product(const CoarseOperator& A, const CellComplex& fine, const Coarsened& coarsened,
                                const Weights& P_transposed, ThreadTeam& team);

} // namespace maille::deform
