#pragma once
/// Elasticity on the lattice: the energy of every cell from the displacements of its corners.
///
/// The energy of a cell of volume V is
///
///   V / 2 eps : (C - alpha diag(E_a)) : eps  +  alpha / 2 sum over its edges of (V / n) E_a (d_a u_a)^2
///     +  V / 24 sum over pairs of axes of G_ab (D_c gamma_ab)^2,
///
/// with eps the mean strain of the cell, C its whole stiffness in the object's frame, E_a = 1 / S_aa and
/// G_ab = 1 / S_(ab)(ab) the moduli of a pull along and of a shear between axes (S = C^-1), d_a u_a the
/// strain of one of the n = 2^(dimension - 1) edges along a, D_c gamma_ab the difference of the mean shears
/// of its two faces across the third axis (3D only), and alpha = 1/3, the largest for which C - alpha
/// diag(E_a) is positive semidefinite for any C. Only rigid motions cost nothing. The edges' terms are on the
/// very links that carry limits. It does not lock: bending is exact, and so is torsion, where Q1 is too
/// stiff.
///
/// The energy above is that of beams, whose sides are free to contract. Sheets differ: where a row of matter
/// along c is one or two cells (thin_axes), the edges' and twists' part of the face differences g = (D_c
/// eps_a, D_c eps_b, D_c gamma_ab), V / 24 (E_a g_1^2 + E_b g_2^2 + G_ab g_3^2), is replaced by that of a
/// plate, V / 24 g . Q g. Q is the stiffness of plane stress across c: the inverse of the rows and columns
/// aa, bb, ab of S. In thicker bodies the mean strains of cells give this.
///
/// Cells of one kind (material, fibre, thin axes) share a table; cells without matter are skipped.
///
/// Source  docs/theory.md, section 3 (LAT)
/// Checked by  tests/deform/elastic/lattice_elasticity_test.cpp

#include "elastic/model/lattice_kernel.hpp"
#include "lattice/field_memory.hpp"
#include "maille/base/arena.hpp"
#include "maille/scene/answer.hpp"
#include "parallel/thread_team.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>

namespace maille::deform {

template<int dimension>
inline constexpr int corners_of_cell = 1 << dimension;

class LatticeElasticity {
public:
  static constexpr double alpha = 1.0 / 3;
  static constexpr int planes_per_window = 4; ///< planes of nodes that for_each_window() takes at once

  /// @param scene must outlive this
  explicit LatticeElasticity(const Scene& scene);
  LatticeElasticity(const Scene& scene, ThreadTeam& team);
  /// Elasticity of some layers of cells in 3D only. With few kinds, kinds and their numbers are those of the
  /// whole scene; with many, those of the layers. Displacements begin at the lowest plane of nodes of the
  /// layers.
  LatticeElasticity(const Scene& scene, ThreadTeam& team, LayerRange layers);

  /// Every cell has a stiffness of its own, symmetric and positive definite, object's frame [Pa]. @pre 3D
  LatticeElasticity(const Scene& scene, ThreadTeam& team,
                    const std::function<Matrix6(std::int64_t cell)>& stiffness);

  const Grid& grid() const { return grid_; }
  /// Reads the constants of the materials anew; kinds and their cells stay.
  void renew();

  /// forces = K u: the external forces that hold the displacement [N]; dense, [component][node].
  /// Same bits for any number of threads.
  void apply(const Displacement& u, Displacement& forces, ThreadTeam& team) const;
  /// A range of planes of nodes across z, to which apply() can be restricted.
  struct Window {
    int first_plane = 0, end_plane = 0;
    std::int64_t first_node = 0, n_nodes = 0;
    std::array<const double*, 3> u{}, forces{}; ///< by component, of first_node on [m], [N]
  };
  /// Calls visit(window) for successive windows of planes; a window's forces are valid during the call. Bits
  /// equal those of apply(), in the memory of a few planes. @pre in 3D
  /// @param planes of nodes that matter; a window may start before them with incomplete forces. The first is
  /// 0 or a multiple of 4
  void for_each_window(const Displacement& u, ThreadTeam& team, PlaneRange planes,
                       const std::function<void(const Window&)>& visit) const;
  /// Writes the displacements of some planes of nodes into zeroed memory, by component. @return false if it
  /// stays zero
  using PutPlanes = std::function<bool(int first_plane, int end_plane, const std::array<double*, 3>& to)>;
  /// The same for displacements that are not stored as a whole.
  void for_each_window(const PutPlanes& put, ThreadTeam& team, PlaneRange planes,
                       const std::function<void(const Window&)>& visit) const;
  /// The diagonal of K [N/m].
  Displacement diagonal() const;
  /// Forces at the corners of one cell of matter [N], from their displacements; columns are corners, by bits
  /// x y z, rows beyond the dimension are zero. @tparam dimension of the scene
  template<int dimension>
  Eigen::Matrix<double, 3, 1 << dimension>
  cell_forces(std::int64_t cell, const Eigen::Matrix<double, 3, 1 << dimension>& u) const;

  /// Stiffness of a cell of one kind of matter [N/m], [N].
  struct Kind {
    /// V (C - alpha diag E), order of the scene's dimension, by mean_coefficient().
    std::array<double, 21> mean{};
    std::array<double, 3> edge{};  ///< alpha V / n E_a / h_a^2
    std::array<double, 3> shear{}; ///< V / 12 G_ab, by the third axis
    /// Bending of thin cells: V / 12 (Q - diag(E_a, E_b, G_ab)) for the axis c across, a and b the next two;
    /// zero along axes that are not thin. Empty if every cell has its own fibre direction.
    List<Eigen::Matrix3d> bending;
    std::uint8_t thin = 0; ///< bit c for an axis across which it is

    double mean_at(int p, int q) const { return mean[mean_coefficient(p, q)]; }
    double largest_mean() const; ///< of the diagonal
  };
  const List<Kind>& kinds() const { return kinds_; }
  static constexpr std::size_t few_kinds = std::numeric_limits<std::uint8_t>::max();
  /// Number of kinds in the scene; few_kinds + 1 stands for all larger numbers.
  std::size_t n_kinds() const {
    return has_few_kinds_ ? kinds_.size() : std::max(kinds_.size(), few_kinds + 1);
  }
  /// Energy of a cell relative to its kind (see Specimen::weight_of).
  double weight(std::int64_t cell) const { return scene_.specimen.weight_of(cell); }
  bool has_weights() const { return scene_.specimen.has_weights(); }
  /// Springs to the ground, which are part of K; by default those of the scene.
  const List<NodalSpring>& springs() const { return springs_; }
  /// Replaces the springs. @param springs sorted by node, each once
  void set_springs(List<NodalSpring> springs) { springs_ = std::move(springs); }
  /// Index of the cell's kind in kinds(). @pre the cell holds matter, in the layers
  std::int32_t kind_number(std::int64_t cell) const {
    const auto at = static_cast<std::size_t>(cell - first_cell_);
    return !few_kinds_of_.empty() ? few_kinds_of_[at] : kind_of_.empty() ? 0 : kind_of_[at];
  }

private:
  void find_thin(ThreadTeam& team);
  void find_kinds(ThreadTeam& team);
  struct FirstOfKind {
    std::int64_t cell;
    std::uint8_t thin;
  };
  bool number_kinds(std::int64_t begin, std::int64_t end, std::size_t most, List<FirstOfKind>& first);
  bool is_known(std::int64_t cell) const { return cell >= first_cell_ && cell < end_cell_; }
  void set_kind(std::int64_t cell, std::int32_t kind);
  class Stiffnesses;
  template<class Stiffness>
  Kind kind_for(const Stiffness& C, const Eigen::Matrix<double, 6, 6>& S, std::uint8_t thin) const;
  const Kind& kind(std::int64_t cell) const { return kinds_[kind_number(cell)]; }
  /// Numbers of nodes by component, of first_node on.
  template<class Number>
  struct Nodes {
    std::array<Number*, 3> values{};
    std::int64_t first_node = 0;

    Number* at(std::size_t component, std::int64_t node) const {
      return values[component] + (node - first_node);
    }
  };
  Nodes<const double> all_of(const Displacement& u) const;
  /// Calls visit(window) where planes(first plane, end) has the displacements, if they are not all zero.
  template<class Planes>
  void visit_windows(const Planes& planes, ThreadTeam& team, PlaneRange asked,
                     const std::function<void(const Window&)>& visit) const;
  template<int dimension>
  void apply_to_layer(const Nodes<const double>& u, const Nodes<double>& forces, int layer) const;
  void add_run(const Nodes<const double>& u, const Nodes<double>& forces, const Kind& of, std::int64_t node,
               std::int64_t n) const;
  template<int dimension>
  void add_cell(const Kind& kind, const double* u, double* force) const;

  const Scene& scene_;
  const Grid& grid_;
  std::int64_t first_cell_ = 0, end_cell_; ///< that are known
  std::int64_t first_node_ = 0;            ///< of displacements
  bool has_few_kinds_ = true;
  List<Kind> kinds_;
  /// Per known cell; both empty: all of the first kind.
  List<std::int32_t> kind_of_;
  List<std::uint8_t> few_kinds_of_; ///< where a byte can name them
  List<NodalSpring> springs_;
};

} // namespace maille::deform
