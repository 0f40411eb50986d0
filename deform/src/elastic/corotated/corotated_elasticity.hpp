#pragma once
/// The lattice's elasticity in a frame for every cell, which turns with it.

#include "elastic/model/lattice_elasticity.hpp"

#include <Eigen/Geometry>

#include <vector>

namespace maille::deform {

/// The energy is the sum over cells of matter of
///
///   1/2 w . K w,    w_i = R^T (X_i + u_i) - X_i up to a shift,    R the rotation nearest to the cell's mean
///   F = I + du/dx,
///
/// with K the cell's matrix of LatticeElasticity: what `coupled` gives to a displacement, measured in a frame
/// that turns with the cell, fibres and all. Rigid motions cost nothing, however large; for small
/// displacements it is the energy of `coupled`, and its forces differ in second order. With one mean F per
/// cell, w's mean strain is Biot's, U - I.
///
/// R depends on u, so the forces are more than R K w. With f = K w, U = R^T F, m = sum w_i x f_i the moment
/// that f has left, and g_i the derivative of the mean gradient by corner i,
///
///   force on corner i = R (f_i - (Z m) x g_i),    Z = (tr(U) - U)^-1,
///
/// the exact gradient of the energy, which therefore pulls and turns the body as a whole at nothing. (The
/// second term is of the order of strain squared; without it energy could rise.)
///
/// Matter that is turned inside out is measured from the nearest rotation all the same, and finds its way
/// back.
///
/// Source  Muller and Gross 2004 (Graphics Interface) for a frame per element; Chao, Pinkall, Sanan,
///         Schroeder 2010 (ACM TOG 29) for forces that are the gradient. There elements are tetrahedra or
///         their energy is isotropic; here it is any quadratic form that costs rigid motions nothing
/// Checked by  tests/deform/elastic/blocks_limits_test.cpp
class CorotatedElasticity {
public:
  /// @param scene in 2D or 3D, must outlive this, as must `linear`, which is of the same scene
  CorotatedElasticity(const Scene& scene, const LatticeElasticity& linear);

  /// Turns every cell's frame with u. @return the energy [J]; forces = its gradient [N], dense.
  /// Same bits for any number of threads that have asked the same before.
  double evaluate(const Displacement& u, Displacement& forces, ThreadTeam& team);
  /// Energy and forces with the frames as they are: of a quadratic function of u.
  double evaluate_in_fixed_frames(const Displacement& u, Displacement& forces, ThreadTeam& team);
  /// forces = sum over cells of R K R^T p: the second derivative in fixed frames, positive semidefinite.
  void apply_in_fixed_frames(const Displacement& p, Displacement& forces, ThreadTeam& team) const;
  /// What fibres pull with, a cell each [Pa], in place of the scene's; empty: nothing. The pull turns with
  /// its cell: its energy is sigma a.E.a a volume, E the mean strain of w.
  void set_active_stress(std::vector<double> stress) { active_stress_ = std::move(stress); }
  /// Energy of contracting fibres at the last evaluation [J], in addition to the elastic energy of
  /// evaluate().
  double active_energy() const;

  /// Adds the forces that moments on the frames amount to: the derivative of the sum of moment . turn.
  /// @param moments by cell, of no cells without matter [N m]; @pre last evaluated at u
  void add_moments(const Displacement& u, const List<Eigen::Vector3d>& moments, Displacement& forces,
                   ThreadTeam& team) const;
  /// Turns every frame as far as a linear displacement d says, by the angle that it stands for and not by its
  /// arc tangent.
  /// Source  Choi and Ko 2005 (IEEE TVCG 11), modal warping
  void warp_frames(const Displacement& d);

  /// Frame of every cell; meaningless outside the body.
  const List<Eigen::Quaterniond>& frames() const { return frame_; }
  /// Cells whose mean F turned them inside out at the last evaluation.
  std::int64_t n_inverted() const;
  const Scene& scene() const { return scene_; }

private:
  enum class Frames { turn, stay };
  template<int dimension>
  struct Cell;
  template<Frames frames>
  double evaluate_all(const Displacement& u, Displacement& forces, ThreadTeam& team);
  template<int dimension, Frames frames>
  double evaluate_cell(std::int64_t cell, Cell<dimension>& at);
  /// Calls work.operator()<dimension>(layer of cells) for every second layer at a time: none of them share a
  /// node.
  template<class Work>
  void for_each_layer(ThreadTeam& team, Work&& work) const;
  /// Calls visit(cell, its first node) for the cells of matter of a layer.
  template<class Visit>
  void for_each_cell(int layer, Visit&& visit) const;

  const Scene& scene_;
  const Grid& grid_;
  const LatticeElasticity& linear_;
  List<Eigen::Quaterniond> frame_;
  template<int dimension>
  Eigen::Matrix3d active_stress(std::int64_t cell) const;

  std::vector<double> active_stress_;
  std::vector<double> energy_, active_energy_; ///< of layers
  std::vector<std::int64_t> inverted_;         ///< cells of layers
  std::array<std::int64_t, 8> offset_{};       ///< of corners from the first one
};

} // namespace maille::deform
