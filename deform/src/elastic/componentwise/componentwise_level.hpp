#pragma once
/// One level of the componentwise multigrid: operator, fixed nodes and fields.
///
/// The operator is the graph Laplacian of one displacement component: at a node, the sum over its links of
/// weight (u_node - u_neighbour), plus an anchor times u_node. Fields u (solution), f (right-hand side) and r
/// (residual) are float32, a number per node, rows padded to cache lines. Fixed nodes have 0 in the inverse
/// of the diagonal, which thereby masks them. A 2D body is stored as planes of one row each.
///
/// A box stores its weights as factors of the axes; any other body one weight per link.

#include "elastic/componentwise/axis_coarsening.hpp"
#include "elastic/componentwise/componentwise_kernel.hpp"
#include "elastic/krylov/field_map.hpp"
#include "elastic/multigrid/plane_multigrid.hpp"
#include "lattice/field_memory.hpp"
#include "maille/base/grid.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

namespace maille::deform {

/// A node whose displacement is given. Nodes are numbered densely, x fastest.
struct FixedNode {
  std::int64_t node = 0;
  double value = 0; ///< in the unit of the field
};

/// Length of a row of `n` nodes in memory.
inline std::int64_t padded_row(int n) {
  return (n + line_of_floats - 1) / line_of_floats * line_of_floats;
}

/// One float per node, rows padded to lines, a line of zeros before and after. Zero at first.
class PaddedArray {
public:
  PaddedArray() = default;
  explicit PaddedArray(std::size_t size) : array_(size + 2 * line_of_floats), size_(size) {}
  PaddedArray copy() const {
    PaddedArray made(size_);
    std::copy_n(data(), size_, made.data());
    return made;
  }
  float* data() { return array_.data() + line_of_floats; }
  const float* data() const { return array_.data() + line_of_floats; }
  std::size_t size() const { return size_; }

private:
  AlignedArray<float> array_;
  std::size_t size_ = 0;
};

/// The weights of the links of a level, in units of the largest on the finest.
struct LinkWeights {
  /// On a box: factors of the axes, links one shorter than masses (see ComponentwiseOperator).
  std::array<std::vector<double>, 3> axis_link, axis_mass;
  /// On any other body; empty on a box.
  std::array<PaddedArray, 3> link;

  bool is_box() const { return link[0].size() == 0; }
};

/// Springs to rest at coarse nodes, ascending by node. A coarse function that is interpolated and cut off at
/// fixed nodes is steeper than coarse links know. Without anchors, corrections beside a hold overshoot,
/// without bound under anisotropy.
using Anchors = std::map<std::int64_t, double>;

class ComponentwiseLevel {
public:
  static constexpr std::int64_t nodes_worth_threads = nodes_worth_a_thread;
  /// @param fixed ascending by node
  ComponentwiseLevel(const Index3& nodes, std::array<std::vector<double>, 3> place, LinkWeights weights,
                     List<FixedNode> fixed, Anchors anchors = {});

  /// The next coarser level, or null. It coarsens the axes whose links are among the strongest, because
  /// pointwise relaxation smooths along these only.
  std::unique_ptr<ComponentwiseLevel> coarser();

  const ComponentwiseOperator& A() const { return operator_; }
  const Index3& nodes() const { return nodes_; }
  std::int64_t n_nodes() const { return std::int64_t{1} * nodes_[0] * nodes_[1] * nodes_[2]; }
  const LinkWeights& weights() const { return weights_; }
  const List<FixedNode>& fixed() const { return fixed_; }
  const Anchors& anchors() const { return anchors_; }
  const std::array<AxisCoarsening, 3>& transfer() const { return *transfer_; }
  /// Place of a node in the padded arrays.
  std::int64_t offset(const Index3& at) const {
    return at[0] + at[1] * operator_.row_stride + at[2] * operator_.slab_stride;
  }
  Index3 node_at(std::int64_t node) const;
  std::int64_t node(const Index3& at) const {
    return at[0] + nodes_[0] * (at[1] + std::int64_t{1} * nodes_[1] * at[2]);
  }
  /// Weight of the link from a node to the next along `axis`; 0 without a link.
  double weight(const Index3& at, int axis) const;
  /// Sum of the weights of a node's links, and its anchor.
  double diagonal(const Index3& at) const;
  bool may_move(const Index3& at) const;
  /// Calls visit(FieldRow) for all rows. See FieldRow.
  template<class Visit>
  void for_each_row(ThreadTeam& team, const Visit& visit) const {
    team.run(nodes_[2], [&](int z, int) {
      for (int y = 0; y < nodes_[1]; ++y)
        visit(FieldRow{0, offset({0, y, z}), node({0, y, z}), nodes_[0],
                       operator_.inverse_diagonal[y + std::int64_t{1} * nodes_[1] * z]});
    });
  }

  /// Puts the values of the fixed nodes into a field.
  void place_fixed(float* field) const;
  void clear(PaddedArray& field) const;

  PaddedArray u, f, r;

  // Interface of PlaneLevel.
  int n_planes() const { return nodes_[2]; }
  const std::vector<float>& relaxation() const;
  void start(int z, float weight, float, float* to) { start_relaxation(operator_, z, weight, f.data(), to); }
  void relax(int z, float weight, const float* from, float* to) const {
    relax_plane(operator_, z, weight, f.data(), from, to);
  }
  void find_residual(int z) { deform::find_residual(operator_, z, f.data(), u.data(), r.data()); }
  void restrict_to(const ComponentwiseLevel& coarser, int z, const float* from, float* to) const;
  void prolong_from(const ComponentwiseLevel& coarser, int z, const float* from, bool replaces,
                    float* to) const;
  double dot(int z, const float* a, const float* b) const { return deform::dot(operator_, z, a, b); }
  auto coarse_planes_after(int z) const { return transfer()[2].coarse_after(z); }
  void go_down(ComponentwiseLevel& coarser, ThreadTeam& team, CycleStart start) {
    go_down_planes(*this, coarser, team, start);
  }
  void come_up(const ComponentwiseLevel& coarser, ThreadTeam& team, double* products) {
    come_up_planes(*this, coarser, team, products);
  }
  /// 64 nodes or fewer: their inverse fits the first cache.
  bool is_small() const { return n_nodes() <= 64; }
  bool is_thin(std::int64_t) const { return false; }
  CoarsestSolve::Unknowns unknowns() const;
  void for_each_entry(const CoarsestSolve::Unknowns& unknowns, const CoarsestSolve::Visit& visit) const;

private:
  void make_operator();
  void lay_out_anchors();
  void invert_diagonal_of_box();
  void invert_diagonal_of_body();
  std::vector<bool> axes_to_coarsen() const;
  double strength(int axis) const;

  Index3 nodes_;
  std::array<std::vector<double>, 3> place_;
  LinkWeights weights_;
  List<FixedNode> fixed_;
  Anchors anchors_;
  ComponentwiseOperator operator_;
  std::array<PaddedArray, 3> axis_link_, axis_mass_;
  List<const float*> inverse_rows_;
  List<const float*> anchor_rows_;
  std::vector<PaddedArray> row_pool_;
  PaddedArray inverse_;
  std::unique_ptr<std::array<AxisCoarsening, 3>> transfer_;
};

/// r = scale (f - A u) in float32 at free nodes, 0 elsewhere, for one plane.
/// @param u dense; @param f dense, in the operator's unit; nullptr: no forces
/// @return the largest |f - A u| in the plane
double find_true_residual(const ComponentwiseLevel& level, int z, const double* u, const double* f,
                          double scale, float* r);
/// f = scale A u for one plane, at fixed nodes too; dense.
void find_forces(const ComponentwiseLevel& level, int z, const double* u, double scale, double* f);
/// Half of the sum of weight (difference)^2 over the links that start in a plane.
double energy_of_plane(const ComponentwiseLevel& level, int z, const double* u);
/// A u at one node, fixed or free.
double force_on(const ComponentwiseLevel& level, const Index3& at, const double* u);

} // namespace maille::deform
