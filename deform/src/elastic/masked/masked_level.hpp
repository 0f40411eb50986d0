#pragma once
/// Finest multigrid level of a body of any shape: cell stiffness, operator, and fixed components.
///
/// Fields are float32 and scaled: displacements times scale() of their axis, forces divided by it and by
/// unit(), so that entries are of order 1 for any spacing and modulus. A field has one number per component
/// and slot; slots follow the rows of nodes that touch the body (MaskedRows), padded to whole vectors.
/// inverse() is the inverse of the diagonal and doubles as the mask: 0 where a component is fixed.
///
/// The operator applies cell by cell from a few coefficients per cell (MaskedOperator), shared by all cells
/// of a kind. It equals LatticeElasticity within float32 rounding. Springs are added
/// as sparse rows.

#include "elastic/masked/block_matrix.hpp"
#include "elastic/masked/cell_complex.hpp"
#include "elastic/masked/coarse_operator.hpp"
#include "elastic/masked/masked_kernel.hpp"
#include "elastic/masked/piece_assembly.hpp"
#include "elastic/masked/slabs.hpp"
#include "elastic/model/lattice_elasticity.hpp"
#include "lattice/field_memory.hpp"
#include "maille/scene/answer.hpp"
#include "parallel/thread_team.hpp"

#include <Eigen/Core>

#include <array>
#include <utility>
#include <vector>

namespace maille::deform {

using CellCoefficients = std::array<double, MaskedOperator::most_coefficients>;

/// What coefficients are of the numbers of a kind of matter, each of its own.
/// @param scale per axis: spacing over the unit of length; forces are those of displacements times it
CellCoefficients coefficient_factors(const Vec3& spacing, const Vec3& scale, double unit);
CellCoefficients coefficients_of(const LatticeElasticity::Kind& kind, const CellCoefficients& factors);
CellMatrix cell_matrix(const CellCoefficients& c);
using CellDiagonal = std::array<double, 24>;
CellDiagonal cell_diagonal(const CellCoefficients& c, bool bends); ///< of the same

/// Fields are float32, component after component, each with a number for every slot of MaskedRows:
/// displacements times scale() of their axis, forces over it and over unit().
class MaskedLevel {
public:
  /// @param scene in 3D; must outlive this @param prescribed which components of which nodes do not move
  MaskedLevel(const Scene& scene, const LatticeElasticity& elasticity,
              const std::vector<Prescribed>& prescribed, ThreadTeam& team);
  /// A rank's part: what is said of a field below is so in its own planes; in the others it is nothing to
  /// rely on, but what fields are to have in the planes next to them is asked of exchange_borders().
  /// @param elasticity of slabs.layers() @pre no springs where slabs are shared
  MaskedLevel(const Scene& scene, const LatticeElasticity& elasticity,
              const std::vector<Prescribed>& prescribed, ThreadTeam& team, const Slabs& slabs);

  const Slabs& slabs() const { return slabs_; }
  void exchange_borders(AlignedArray<float>& field, int above = 1) const {
    slabs_.exchange_borders(rows_, component_stride(), field.data(), above);
  }
  const MaskedRows& rows() const { return rows_; }
  std::int64_t component_stride() const { return operator_.component_stride; }
  static constexpr std::int64_t stride_of(std::int64_t n_slots) { return (n_slots + 15) / 16 * 16; }
  std::int64_t field_size() const { return 3 * operator_.component_stride; }
  /// With the padding that loops may read.
  AlignedArray<float> field() const {
    return AlignedArray<float>(static_cast<std::size_t>(field_size()) + 16);
  }
  double unit() const { return unit_; } ///< of forces over displacements [N/m]
  const Vec3& scale() const { return scale_; }
  CellCoefficients coefficients_of(const LatticeElasticity::Kind& kind) const {
    return deform::coefficients_of(kind, factors_);
  }
  /// Inverse of the diagonal; 0 where a component is fixed, or outside the body.
  const float* inverse() const { return inverse_.data(); }
  /// Other components than before do not move from now on.
  void set_fixed(const std::vector<Prescribed>& prescribed);
  /// The constants of matter are those that `elasticity` has by now; kinds of matter and where they are, what
  /// is fixed, and the unit stay.
  void renew_matter(ThreadTeam& team);
  /// forces = A displacement, of fixed components too. Same bits for any number of threads.
  void apply(const float* displacement, float* forces, ThreadTeam& team) const;
  // The same, and what is done with the forces of a plane of nodes while they are in the cache.
  /// Ap = A p where components may move, 0 elsewhere. @return p . Ap
  double apply_and_dot(const float* p, float* Ap, ThreadTeam& team);
  /// u += weight (f - A u) / diagonal, in the memory of r. @return where it is asked for, u . f
  void relax(float weight, ThreadTeam& team);
  double relax_and_dot(float weight, ThreadTeam& team);
  /// r = f - A u where components may move, 0 elsewhere.
  void find_residual(ThreadTeam& team);

  /// f = eigenvalue_noise(), the same on any number of ranks.
  void set_noise(ThreadTeam& team);
  /// Dot product of two fields.
  double dot(const float* a, const float* b, ThreadTeam& team);

  /// Cells of matter, in the grid's order; vertices are slots.
  CellComplex complex(ThreadTeam& team) const;
  /// Stiffness of the springs to the ground, by slots; no blocks without springs.
  BlockMatrix springs_as_matrix() const;
  /// The operator between the coarse functions of `coarsened`, which was made of complex(); zero where
  /// components are fixed. @param by_patterns where most pieces are alike
  CoarseOperator galerkin_product(const CellComplex& fine, const Coarsened& coarsened, bool by_patterns,
                                  ThreadTeam& team) const;
  /// The same where ranks share it: the rank's rows. @param whole becomes that of all on the first rank
  /// @param cells of all, there
  CoarseOperator galerkin_product(const CellComplex& fine, const Coarsened& coarsened,
                                  const SharedPieces* shared, bool by_patterns, ThreadTeam& team,
                                  const List<ComplexCell>& cells, CoarseOperator* whole) const;
  AlignedArray<float> u, f, r;
  /// The fields are not needed while coarser grids are built.
  void release_fields() {
    u = {};
    f = {};
    r = {};
  }
  void make_fields() {
    u = field();
    f = field();
    r = field();
  }

  /// Calls work(first entry, how many, part) for parts of the entries of a field.
  template<class Work>
  void for_each_part(ThreadTeam& team, Work&& work) const {
    for_parts(static_cast<std::size_t>(field_size()), team,
              [&](std::size_t first, std::size_t end, std::size_t part) {
                work(static_cast<std::int64_t>(first), static_cast<std::int64_t>(end - first),
                     static_cast<int>(part));
              });
  }
  int n_parts() const { return static_cast<int>(n_parts_of(static_cast<std::size_t>(field_size()))); }

private:
  double sum_over_planes() { return slabs_.total(sums_); }
  template<class Finish>
  void apply_by_planes(const float* displacement, float* forces, ThreadTeam& team,
                       const Finish& finish) const;
  template<class Work>
  void for_components(int plane, const Work& work) const;

  static bool has_table(const LatticeElasticity& elasticity);
  bool is_known(const Index3& node) const;
  void choose_unit(const LatticeElasticity& elasticity);
  template<class Work>
  void for_layers(ThreadTeam& team, const Work& work) const;
  template<class Visit>
  void for_each_cell(const CellRun& run, const Visit& visit) const;
  void set_coefficients(const LatticeElasticity& elasticity, ThreadTeam& team);
  void set_table(const LatticeElasticity& elasticity, ThreadTeam& team);
  void set_own_coefficients(const LatticeElasticity& elasticity, ThreadTeam& team);
  void set_kinds_of_blocks(ThreadTeam& team);
  void set_inverse(const LatticeElasticity& elasticity, ThreadTeam& team);

  void set_springs(const LatticeElasticity& elasticity);

  struct SlotSpring {
    std::int32_t slot = 0;
    std::array<float, 9>
        block{}; ///< in the units of fields, column after column; 0 where components are fixed
  };

  const Scene& scene_;
  const LatticeElasticity& elasticity_;
  Slabs slabs_;
  MaskedRows rows_;
  List<SlotSpring> springs_;
  double unit_ = 1;
  Vec3 scale_{1, 1, 1};
  CellCoefficients factors_{}; ///< of coefficients
  MaskedOperator operator_;
  AlignedArray<float> coefficients_;
  AlignedArray<std::uint8_t> kind_, block_kind_;
  AlignedArray<float> inverse_;
  std::vector<double> sums_; ///< of its own planes of nodes
  /// Entries of inverse_ before components were fixed.
  std::vector<std::pair<std::size_t, float>> fixed_;
};

/// The operator of the next coarser grid, as blocks. @param fine what A's grid was `coarsened` of
/// @param P_transposed of its interpolation
CoarseOperator galerkin_product(const CoarseOperator& A, const CellComplex& fine, const Coarsened& coarsened,
                                const Weights& P_transposed, ThreadTeam& team);

} // namespace maille::deform
