#pragma once
/// Finite-strain elasticity of the lattice: energy, forces and tangent from each cell's deformation gradient.
///
/// F = I + H is the mean deformation gradient of a cell, E = (F^T F - I) / 2, W the law of its material (see
/// materials/law.hpp), V its volume at rest. h_i is what the displacement of corner i has beyond F, and K the
/// matrix of LatticeElasticity. The energy of a cell is
///
///   V W(E) + V T (|F a| - 1) + 1/2 w . K w,   w_i = F^T h_i,
///
/// with T the active stress along the fibre a at rest. w is the change of Green-Lagrange strain within the
/// cell, to first order; K gives it the edges, twists and plates of small strain, as w has no mean gradient.
///
/// In 2D and 1D, strains out of the scene's directions are 0 (plane strain) or such that their stresses are 0
/// (plane stress, 1D): these are solved cell by cell and condensed out of the tangent.
///
/// Nearly incompressible matter shortens Newton steps: a step that keeps J to first order changes it to
/// second order, at a large energy. So the tangent uses a pressure p per cell in place of kappa ln J, kappa
/// the mean of C_12, C_13, C_23: the value that the last step predicts for kappa ln J to first order. That is
/// Newton's method for displacement and pressure, with the pressure condensed cell by cell; at convergence p
/// = kappa ln J.
///
/// Exact: forces are the gradient of the energy, the tangent their derivative; turns cost no energy; the
/// limit of small strain is LatticeElasticity. One mean volume per cell: no locking. Heuristic: K is that of
/// rest, so bending within a cell is as stiff as at rest; its part falls with the square of the spacing.
///
/// Source  docs/theory.md, section 4; Simo, Taylor, Pister 1985 (Comput. Methods Appl. Mech. Eng. 51) for the
///         pressure; Belytschko, Liu, Moran 2000, section 8.7, for one-point elements with
///         stabilisation
/// Checked by  tests/deform/elastic/finite_elasticity_test.cpp

#include "elastic/finite/cell_modes.hpp"
#include "elastic/finite/law_kernel.hpp"
#include "elastic/finite/tangent_kernel.hpp"

#include <Eigen/Geometry>

#include <vector>

namespace maille::deform {

/// Same bits for any number of threads, given the same history of calls.
class FiniteElasticity {
public:
  /// @param scene must outlive this, as must `linear`, which is of the same scene
  FiniteElasticity(const Scene& scene, const LatticeElasticity& linear);

  /// @return the energy [J], infinite if a cell is inverted; forces = its gradient [N], dense
  double evaluate(const Displacement& u, Displacement& forces, ThreadTeam& team);
  /// exact: the derivative of the forces, except for pressures. positive: with clamped negative eigenvalues
  /// of cells and without the rotation of modes beyond F; positive semidefinite, for states far from a
  /// minimum.
  /// Source  Teran, Sifakis, Irving, Fedkiw 2005 (Symposium on Computer Animation), clamped eigenvalues
  enum class Convexity { exact, positive };
  /// Computes the tangent and the frames of cells at u, for apply_tangent() and the functions below.
  void linearise(const Displacement& u, Convexity convexity, ThreadTeam& team);
  /// The tangent of linear elasticity measured in the present frames, positive semidefinite.
  /// @param at_rest receives the forces of the undeformed body in turned frames [N]
  void linearise_in_frames(Displacement& at_rest, ThreadTeam& team);
  /// Updates pressures for a step of that length along a direction, from the last linearise().
  void step_pressures(const Displacement& direction, double length, ThreadTeam& team);
  /// Resets pressures to those of the displacement.
  void forget_pressures() { has_pressures_ = false; }
  /// forces = d(forces)/du p, at the state of the last linearise().
  void apply_tangent(const Displacement& p, Displacement& forces, ThreadTeam& team) const;
  /// The stiffness of a cell for small strains in its frame, on top of the state of the last linearise(),
  /// made positive definite [Pa].
  Matrix6 stiffness_in_frame(std::int64_t cell) const;
  /// Replaces the active stress of fibres, one per cell [Pa]; empty: none.
  void set_active_stress(std::vector<double> stress) { active_stress_ = std::move(stress); }
  /// Elastic energy of every cell at the last evaluation [J]; 0 outside the body.
  const std::vector<double>& energies() const { return energies_; }
  /// Energy of contracting fibres at the last evaluation [J], a part of evaluate()'s result.
  double active_energy() const;
  /// Cells whose mean F is inverted at the last evaluation.
  std::int64_t n_inverted() const;

  /// Rotation of every cell, nearest to F at the last turn_frames(); meaningless outside the body.
  const List<Eigen::Quaterniond>& frames() const { return frame_; }
  void turn_frames(const Displacement& u, ThreadTeam& team);
  /// Rotates every frame by the angle of a linear displacement d, not by its arc tangent.
  /// Source  Choi and Ko 2005 (IEEE TVCG 11), modal warping
  /// @return root mean square of the angles [rad]
  double warp_frames(const Displacement& d);
  /// Adds the forces that hold the nodes against springs to the ground [N].
  void add_springs(const Displacement& u, Displacement& forces) const;
  /// Adds the forces equivalent to moments on frames: the derivative of the sum of moment . rotation.
  /// @param moments by cell, of no cells without matter [N m]; @pre frames turned at u
  void add_moments(const Displacement& u, const List<Eigen::Vector3d>& moments, Displacement& forces,
                   ThreadTeam& team) const;
  const Scene& scene() const { return scene_; }

private:
  /// A kind of matter.
  struct Matter {
    Matrix6 stiffness = Matrix6::Zero(); ///< object's frame [Pa]
    Matrix6 in_scene = Matrix6::Zero();  ///< reduced to the scene's dimension; other rows are zero
    std::vector<double> beyond;          ///< stiffness of what lies beyond the mean, by pairs_ [N/m]
    bool is_in_vectors = false, is_corotated = false; ///< see LawRun; else cell by cell
    double mu = 0, lambda = 0;                        ///< of LawRun [Pa]
  };
  /// Energies and inverted cells of a layer.
  struct OfLayer {
    double energy = 0, active = 0;
    std::int64_t inverted = 0;
  };
  LawResponse respond(std::int64_t cell, Eigen::Matrix3d& E, double& active_energy) const;
  /// Calls work.operator()<dimension>(layer of cells), for every second layer at a time, so that concurrent
  /// layers share no node.
  template<class Work>
  void for_each_layer(ThreadTeam& team, Work&& work) const;
  /// Calls visit(first cell, number, first node) for runs of cells of matter along x in a layer.
  template<class Visit>
  void for_each_run(int layer, Visit&& visit) const;
  /// Calls visit(cell, its first node) for the cells of matter of a layer.
  template<class Visit>
  void for_each_cell(int layer, Visit&& visit) const;
  /// The same, but visit_run(LawRun, its first cell) for runs of matter that is_in_vectors.
  template<class VisitRun, class Visit>
  void for_each_law(int layer, const Displacement& u, VisitRun&& visit_run, Visit&& visit) const;
  void fill(TangentRun& run, int n, std::int64_t node, const Displacement& u, Displacement* forces) const;
  const Matter& matter_of(std::int64_t cell) const { return matter_[linear_.kind_number(cell)]; }
  template<int dimension>
  void find_matter();
  /// K of what lies beyond the mean gradient, times w [N].
  template<class Beyond>
  Beyond pull(const Matter& matter, const Beyond& w) const;
  template<int dimension>
  void linearise_cell(std::int64_t cell, const CellModes<dimension>& at, Convexity convexity);
  template<int dimension>
  void store_tangent(std::int64_t cell, const Eigen::Matrix3d& F, const Eigen::Matrix<double, 9, 9>& A,
                     const typename CellModes<dimension>::Beyond& h);
  /// Where the numbers of the tangent of a cell begin; they are n_in_row_ apart.
  std::int64_t numbers_of(std::int64_t cell) const {
    return cell / n_in_row_ * n_in_row_ * n_numbers_ + cell % n_in_row_;
  }
  void make_tangent();
  double bulk(std::int64_t cell) const { ///< kappa [Pa]
    const Matrix6& C = matter_of(cell).stiffness;
    return std::max(0.0, (C(0, 1) + C(0, 2) + C(1, 2)) / 3);
  }
  double volume(std::int64_t cell) const { return volume_ * linear_.weight(cell); }

  const Scene& scene_;
  const Grid& grid_;
  const LatticeElasticity& linear_;
  double volume_ = 1;             ///< of a cell [m^3]; in 2D per metre, in 1D per square metre
  List<Matter> matter_;           ///< by kind
  bool has_free_strains_ = false; ///< such that their stresses are zero
  List<Eigen::Quaterniond> frame_;
  std::vector<BeyondPair> pairs_;
  std::int64_t n_in_row_ = 1, n_numbers_ = 0; ///< cells; of TangentNumbers a cell
  List<float> numbers_;
  List<double> volume_pressure_; ///< kappa ln J at the last linearise(), by cell [Pa]
  List<double> pressure_;        ///< by cell [Pa]
  bool has_pressures_ = false;
  std::vector<double> active_stress_;
  std::vector<OfLayer> of_layer_;
  std::vector<double> energies_;         ///< by cell [J]
  std::array<std::int64_t, 8> offset_{}; ///< of corners from the first one
};

template<class Work>
void FiniteElasticity::for_each_layer(ThreadTeam& team, Work&& work) const {
  const int d = grid_.dimension(), layers = grid_.cells()[d - 1];
  run_slabs(team, layers, [&](int layer) {
    if (d == 1)
      work.template operator()<1>(layer);
    else if (d == 2)
      work.template operator()<2>(layer);
    else
      work.template operator()<3>(layer);
  });
}

template<class Visit>
void FiniteElasticity::for_each_run(int layer, Visit&& visit) const {
  const std::int64_t in_layer = grid_.n_cells() / grid_.cells()[grid_.dimension() - 1],
                     begin = layer * in_layer;
  for (std::int64_t row = begin; row < begin + in_layer; row += n_in_row_) {
    const std::int64_t node = grid_.corner(grid_.cell_at(row), 0);
    for (std::int64_t x = 0; x < n_in_row_; ++x) {
      const std::int64_t first = x;
      while (x < n_in_row_ && scene_.specimen.is_matter(row + x))
        ++x;
      if (x > first)
        visit(row + first, x - first, node + first);
    }
  }
}

template<class Visit>
void FiniteElasticity::for_each_cell(int layer, Visit&& visit) const {
  for_each_run(layer, [&](std::int64_t first, std::int64_t n, std::int64_t node) {
    for (std::int64_t x = 0; x < n; ++x)
      visit(first + x, node + x);
  });
}

} // namespace maille::deform
