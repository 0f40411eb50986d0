#pragma once
/// Forces, strain, stress and energy of an answer: of holds, moves and loads, and of labels and materials.
///
/// Forces act on the body, in the world's frame. Figures of parts weigh each cell by its volume at rest.
/// Energies are those of the method if it stores them, else those of mean strains (energy_is_of_means). Frame
/// and signs: mechanics_conventions(), docs/mechanics.md.

#include "maille/scene/answer.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille {

/// Distribution of a figure over the cells of a part, weighted by volume at rest (equal on a grid).
struct Spread {
  double mean = 0, least = 0, most = 0;
  /// Percentiles by volume: the least cell value that this share of the volume does not exceed.
  double percentile_5 = 0, median = 0, percentile_95 = 0;
};

/// A label, a material, or the whole body.
struct PartMechanics {
  std::optional<std::int32_t> label;
  std::string material; ///< its name; for a label: of its first cell; empty: the whole body
  std::int64_t cells = 0;
  double volume_at_rest = 0, volume = 0;     ///< [m^3], in 2D [m^2], in 1D [m]
  std::optional<Spread> fibre_strain;        ///< [1]; if some matter has fibres
  std::optional<Spread> largest_strain;      ///< principal strains [1]
  std::optional<Spread> smallest_strain;     ///< [1]
  std::optional<Spread> fibre_stress;        ///< [Pa]; this and the next for methods with stress
  std::optional<Spread> von_mises, pressure; ///< [Pa]
  std::optional<double> strain_energy;       ///< [J]
  double volume_change() const { return volume / volume_at_rest - 1; }
};

/// Resultant force and moment of one hold, move or load on the body.
struct Resultant {
  std::string name, where; ///< see NamedCondition; one entry `gravity` for all cells
  Vec3 centroid{};         ///< of its nodes or faces; for gravity: centre of mass [m]
  Vec3 force{};            ///< [N]
  Vec3 moment{};           ///< about the centroid [N m]
};

struct Mechanics {
  std::vector<Resultant> holds, moves; ///< empty if the answer has no reactions
  std::vector<Resultant> loads;
  std::vector<PartMechanics> labels; ///< ascending; empty if the body is no segmentation
  std::vector<PartMechanics> materials;
  PartMechanics body;
  bool energy_is_of_means = false; ///< true: energies are computed from mean strain, not by the method
};

/// @param cell_energy  energy of every cell of the grid [J], see deform::cell_energies; empty:
/// Answer::cell_energy, and if that is empty too, half of mean stress times mean strain
/// @param threads the result does not depend on it
/// @pre the answer has a displacement
/// Cost  O(cells), about 1 us and 60 bytes each
Mechanics mechanics_of(const Scene& scene, const Answer& answer, std::vector<double> cell_energy = {},
                       int threads = 1);

/// Only the holds, moves and loads. Cost  O(prescribed, nodes of matter if there is gravity)
Mechanics resultants_of(const Scene& scene, const Answer& answer);

/// The sum of their forces [N].
Vec3 total_force(const std::vector<Resultant>& resultants);

/// Frame, signs and definitions, in words.
std::string_view mechanics_conventions();

/// Imbalance of the forces on a body, and warnings about their use.
struct ForceCheck {
  /// Force and moment that balance holds, moves and loads; the moment is about the mean centroid of the
  /// holds; without holds, of the moves.
  Resultant missing;
  double force_share = 0;  ///< missing force over largest resultant, contraction or sum of loads [1]
  double moment_share = 0; ///< missing moment over the largest about that point, of holds, moves or loads [1]
  std::vector<std::string> caveats; ///< one sentence each; empty if nothing is wrong
};
/// Nothing for an answer without reactions. Cost  as resultants_of()
std::optional<ForceCheck> check_forces(const Scene& scene, const Answer& answer);

/// True if a [test] measures the effect of loads as well.
bool has_load_beside_test(const Scene& scene);

/// Largest ratio, over the materials, of the diagonal of the stiffness in `relaxed` to Young's moduli [1]:
/// 1.35 at a Poisson ratio of 0.3, 1667 at 0.4999.
double stiffening_of_relaxed(const Scene& scene);
/// Above this factor, forces, stress and modulus of `relaxed` are meaningless.
inline constexpr double largest_stiffening = 2;
/// True if an answer's reactions give a modulus of the matter: false if limits clipped moves, and for
/// `relaxed` if it is more than twice too stiff.
bool has_modulus(const Scene& scene, const Answer& answer);

/// Result of the test, from a method's reactions.
struct TestResult {
  double reaction =
      0; ///< on the moved nodes, along the displacement [N], in 2D per metre; for `bend`: moment [N m]
  double stiffness = 0; ///< reaction over displacement [N/m], over the angle [N m/rad]
  /// Young's (axial, bend), shear, or confined modulus of a homogeneous body with the same response; for an
  /// indenter F / (2 R d), which on a half-space is E / (1 - nu^2) [Pa]. Unset for indent in 2D.
  std::optional<double> apparent_modulus;
  std::optional<double> failure; ///< reaction at which the tissue fails [N]; if requested and known
};

/// @param answer has reactions, in the order of scene.prescribed
/// @return nothing without a test, without moves, or for an answer without forces
/// Cost    O(prescribed); for a failure load O(cells log cells)
/// Source  Sneddon 1965 (flat punch); Pistoia et al. 2002, Bone 30:842 (failure)
/// Checked by  tests/deform/standard_test_test.cpp
std::optional<TestResult> test_result(const Scene& scene, const Answer& answer);

} // namespace maille
