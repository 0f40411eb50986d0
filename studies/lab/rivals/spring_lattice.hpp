#pragma once
/// The body as a lattice of springs, which is all that distance constraints know of elasticity.

#include "maille/scene/answer.hpp"

#include <string>
#include <vector>

namespace maille::lab {

/// The springs of one direction, one per grid node that has a neighbour there.
struct SpringDirection {
  Index3 step{};                ///< to the other end, in nodes: an edge or a diagonal of a face of a cell
  std::int64_t offset = 0;      ///< the same in node numbers, > 0
  Vec3 rest{};                  ///< to the other end at rest, in units of length
  std::vector<float> stiffness; ///< per grid node at the near end, in units of stiffness; 0: no spring
};

/// Springs along the edges of the cells of matter and along the diagonals of their faces, so stiff that every
/// uniform strain stores the energy of an isotropic solid.
///
/// With central forces only, Cauchy's relations hold and lambda = mu: Poisson ratio 1/4 in 3D and plane
/// strain, 1/3 in plane stress, whatever the material's. Young's modulus E is the material's, and so mu = 2
/// E / 5, or 3 E / 8 in plane stress. Cells of volume V and edges h_a then need, for each edge and each
/// diagonal that a cell has in its own right,
///
///     k_ab = mu V (h_a^2 + h_b^2) / (2 h_a^2 h_b^2)             diagonals, of which there are two a face
///     k_a  = mu V (3 - sum over b != a of h_a^2 / h_b^2) / h_a^2  edges
///
/// for V C_abab = 2 k_ab h_a^2 h_b^2 / (h_a^2 + h_b^2), V C_aabb the same, and V C_aaaa = k_a h_a^2 + sum
/// over b of 2 k_ab h_a^4 / (h_a^2 + h_b^2). In a cubic lattice all are mu h = 2 E h / 5. In 1D k = E / h. A
/// spring that several cells share has the sum of their parts.
///
/// Source  the sums above; for cubes Gazis, Herman and Wallis 1960 (Physical Review 119) without angular
///         stiffness
class SpringLattice {
public:
  /// O(nodes). Material that is not isotropic is taken by the mean of its three moduli of Young.
  explicit SpringLattice(const Scene& scene);

  /// Why this scene has no such lattice: cells so oblong that an edge would need a negative stiffness; empty
  /// if it has one.
  const std::string& refusal() const { return refusal_; }
  /// What of the scene's materials the lattice does not represent; empty if it does.
  const std::string& note() const { return note_; }
  const std::vector<SpringDirection>& directions() const { return directions_; }
  double unit_of_length() const { return unit_of_length_; } ///< spacing along x [m]
  /// Sum of the stiffnesses of the springs that end at each grid node, in units of stiffness.
  std::vector<float> stiffness_at_nodes() const;
  /// Energy in the springs [J] (per metre in 2D). In float64.
  double strain_energy(const Displacement& displacement) const;

private:
  double edge_factor(const Grid& grid, std::size_t axis) const;
  void add_direction(const Scene& scene, const Index3& step);
  void add_cells(const Scene& scene, SpringDirection& direction, double stiffness_per_modulus) const;

  std::vector<SpringDirection> directions_;
  double unit_of_length_ = 1, unit_of_stiffness_ = 1;
  std::string refusal_, note_;
};

} // namespace maille::lab
