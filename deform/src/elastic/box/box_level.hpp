#pragma once
/// One level of the multigrid of elasticity on a box: operator, fixed components and fields.

#include "elastic/box/box_kernel.hpp"
#include "elastic/componentwise/axis_coarsening.hpp"
#include "elastic/componentwise/componentwise_level.hpp"
#include "elastic/model/fixed_mask.hpp"
#include "elastic/multigrid/plane_multigrid.hpp"
#include "lattice/field_memory.hpp"

#include "maille/base/arena.hpp"

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace maille::deform {

/// Axes of more than two nodes along which the lattice is about as stiff as along its stiffest axis.
std::array<bool, 3> axes_to_coarsen(const Index3& nodes, const BoxCoefficients& coefficients);

/// Memory of the direct solve of the coarsest level [bytes].
std::int64_t box_coarsest_bytes(const Eigen::Matrix<double, 6, 6>& C, const Grid& grid);

class BoxLevel {
public:
  static constexpr std::int64_t nodes_worth_threads = deform::nodes_worth_threads;
  using Stiffness = Eigen::Matrix<double, 6, 6>;

  /// @param place of the nodes along each axis [m], all intervals but the last equally long
  /// @param unit what forces per displacement are counted in [N/m]
  /// @param finer the level before, if any
  BoxLevel(const Stiffness& C, std::array<std::vector<double>, 3> place, double unit, FixedMask fixed,
           const BoxLevel* finer = nullptr);

  /// The next coarser level, or null. It has half the nodes along the stiffest axes, because pointwise
  /// relaxation smooths along these only. A coarse component is fixed if the fine one at its position is, or
  /// if fixed components have at least half of its interpolation weight. Forgets the fixed components.
  std::unique_ptr<BoxLevel> coarser();

  const BoxOperator& A() const { return operator_; }
  /// One component as the componentwise transfers see it: fields and fixed nodes.
  const ComponentwiseOperator& component(int c) const { return components_[c]; }
  const std::array<AxisCoarsening, 3>& transfer() const { return *transfer_; }
  Index3 nodes() const { return {operator_.nodes[0], operator_.nodes[1], operator_.nodes[2]}; }
  std::int64_t n_nodes() const {
    return std::int64_t{1} * operator_.nodes[0] * operator_.nodes[1] * operator_.nodes[2];
  }
  /// Spacing of the regular cells [m].
  double spacing(int axis) const {
    const auto& place = place_[axis];
    return place[1] - place[0];
  }
  /// Place of a node's component in the fields.
  std::int64_t offset(int c, int x, int y, int z) const {
    return c * operator_.component_stride + z * operator_.slab_stride + y * operator_.row_stride + x;
  }
  /// Calls visit(FieldRow) for all rows. See FieldRow.
  template<class Visit>
  void for_each_row(ThreadTeam& team, const Visit& visit) const {
    const int* const n = operator_.nodes;
    team.run(n[2], [&](int z, int) {
      for (std::size_t c = 0; c < 3; ++c)
        for (int y = 0; y < n[1]; ++y) {
          const std::int64_t row = y + std::int64_t{1} * n[1] * z;
          visit(
              FieldRow{c, offset(static_cast<int>(c), 0, y, z), n[0] * row, n[0], operator_.inverse[c][row]});
        }
    });
  }
  bool may_move(int c, int x, int y, int z) const {
    return operator_.inverse[c][y + std::int64_t{1} * operator_.nodes[1] * z][x] > 0;
  }
  /// Upper bound of the eigenvalues of the operator over its diagonal.
  double largest_eigenvalue() const { return largest_eigenvalue_; }
  std::size_t field_size() const { return static_cast<std::size_t>(3 * operator_.component_stride); }

  PaddedArray u, f, r; ///< [component][z][y][x]

  /// Sets the Jacobi steps before and after each coarser level, here and on coarser levels: 2 or more.
  void set_relaxation(int steps);
  /// Scratch memory of the calling thread.
  void* scratch() const;
  // Interface of PlaneLevel.
  int n_planes() const { return operator_.nodes[2]; }
  const std::vector<float>& relaxation() const { return relaxation_; }
  void start(int z, float weight, float step, float* to) {
    start_box(operator_, z, weight, step, r.data(), f.data(), to);
  }
  void relax(int z, float weight, const float* from, float* to) const {
    relax_box(operator_, z, weight, f.data(), from, to, scratch());
  }
  void find_residual(int z) { find_box_residual(operator_, z, f.data(), u.data(), r.data(), scratch()); }
  void restrict_to(const BoxLevel& coarser, int z, const float* from, float* to) const;
  void prolong_from(const BoxLevel& coarser, int z, const float* from, bool replaces, float* to) const;
  double dot(int z, const float* a, const float* b) const { return dot_box(operator_, z, a, b); }
  auto coarse_planes_after(int z) const { return transfer()[2].coarse_after(z); }
  void go_down(BoxLevel& coarser, ThreadTeam& team, CycleStart start) {
    go_down_planes(*this, coarser, team, start);
  }
  void come_up(const BoxLevel& coarser, ThreadTeam& team, double* products) {
    come_up_planes(*this, coarser, team, products);
  }
  /// is_small: few nodes. is_thin: one cell thick along some axis, where interpolation is far too stiff in
  /// bending, and the factor is affordable. @param n_finest nodes of the finest level: a factor may cost
  /// about as much as some cycles on it
  bool is_small() const;
  bool is_thin(std::int64_t n_finest) const;
  CoarsestSolve::Unknowns unknowns() const;
  void for_each_entry(const CoarsestSolve::Unknowns& unknowns, const CoarsestSolve::Visit& visit) const;

private:
  void lay_out_axes();
  void find_largest_eigenvalue(const BoxLevel* finer);
  void invert_diagonal();
  std::vector<int> kinds_along(int axis) const;
  const float* inverse_row(int c, int y, int z, const std::string& key, bool has_fixed);
  FixedMask coarse_fixed() const;
  std::uint8_t coarse_fixed_at(int x, int y, int z) const;

  Stiffness C_;
  std::array<std::vector<double>, 3> place_;
  double unit_;
  FixedMask fixed_;
  std::uint8_t thin_; ///< axes along which the body is one or two cells thick, by bits
  BoxOperator operator_;
  std::array<ComponentwiseOperator, 3> components_;
  std::array<AlignedArray<double>, 6> axes_;
  std::array<PaddedArray, 2> x_axis_;
  std::array<List<const float*>, 3> inverse_rows_;
  std::map<std::string, PaddedArray> rows_; ///< distinct rows, by kinds and fixed nodes
  std::unique_ptr<std::array<AxisCoarsening, 3>> transfer_;
  Index3 block_{}; ///< cells of the box that largest_eigenvalue_ was computed on
  double largest_eigenvalue_ = 0;
  std::vector<float> relaxation_;
};

} // namespace maille::deform
