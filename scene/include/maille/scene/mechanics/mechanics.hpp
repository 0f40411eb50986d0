#pragma once
/// What an answer says of forces, strain, stress and energy: on what holds and moves the body, in its labels
/// and materials.
///
/// Forces act on the body, in the world's frame. Figures of parts weigh each cell by its volume at rest.
/// Energies are the method's own where it has them, else those of mean strains (energy_is_of_means). Frame
/// and signs: mechanics_conventions(), docs/mechanics.md.

#include "maille/scene/answer.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille {

/// A figure over the cells of a part, each of which counts by its volume at rest: on a grid all alike.
struct Spread {
  double mean = 0, least = 0, most = 0;
  /// Percentiles by volume: the least cell value that this share of the volume does not exceed.
  double percentile_5 = 0, median = 0, percentile_95 = 0;
};

/// A label, a material, or the whole body.
struct PartMechanics {
  std::optional<std::int32_t> label;
  std::string material; ///< its name, of a label that of its first cell; empty: the whole body
  std::int64_t cells = 0;
  double volume_at_rest = 0, volume = 0;     ///< [m^3], in 2D [m^2], in 1D [m]
  std::optional<Spread> fibre_strain;        ///< [1]; where some matter has fibres
  std::optional<Spread> largest_strain;      ///< principal strains [1]
  std::optional<Spread> smallest_strain;     ///< [1]
  std::optional<Spread> fibre_stress;        ///< [Pa]; this and the next of methods that have stress
  std::optional<Spread> von_mises, pressure; ///< [Pa]
  std::optional<double> strain_energy;       ///< [J]
  double volume_change() const { return volume / volume_at_rest - 1; }
};

/// What one hold, move or load does to the body.
struct Resultant {
  std::string name, where; ///< see NamedCondition; `gravity` is one for all
  Vec3 centroid{};         ///< of its nodes or faces, of gravity that of the mass [m]
  Vec3 force{};            ///< [N]
  Vec3 moment{};           ///< about the centroid [N m]
};

struct Mechanics {
  std::vector<Resultant> holds, moves; ///< empty where the answer has no reactions
  std::vector<Resultant> loads;
  std::vector<PartMechanics> labels; ///< ascending; empty where the body is no segmentation
  std::vector<PartMechanics> materials;
  PartMechanics body;
  bool energy_is_of_means =
      false; ///< the cells' energies are not the method's, but those of their mean strain
};

/// @param cell_energy  of every cell of the grid [J], see deform::cell_energies; empty: Answer::cell_energy,
///         and where that is empty too, half of mean stress by mean strain
/// @param threads the figures are the same for any number
/// @pre the answer has a displacement
/// Cost  O(cells), about 1 us and 60 bytes each
Mechanics mechanics_of(const Scene& scene, const Answer& answer, std::vector<double> cell_energy = {},
                       int threads = 1);

/// Its holds, moves and loads alone. Cost  O(prescribed, nodes of matter where there is gravity)
Mechanics resultants_of(const Scene& scene, const Answer& answer);

/// The sum of their forces [N].
Vec3 total_force(const std::vector<Resultant>& resultants);

/// Frame, signs and definitions of all of it, in words.
std::string_view mechanics_conventions();

/// How far the forces on a body are from balance, and what they are not good for.
struct ForceCheck {
  /// What holds, moves and loads together lack: a force, and a moment about the middle of what is held,
  /// of what is moved where nothing is.
  Resultant missing;
  double force_share = 0;  ///< of the largest of their forces, a contraction's, and all that is applied [1]
  double moment_share = 0; ///< of the largest moment about that middle, of holds, moves or loads [1]
  std::vector<std::string> caveats; ///< a sentence each; empty where nothing is wrong
};
/// Nothing for an answer without reactions. Cost  as resultants_of()
std::optional<ForceCheck> check_forces(const Scene& scene, const Answer& answer);

/// Whether what a [test] measures is of loads as well.
bool has_load_beside_test(const Scene& scene);

/// Largest ratio, over the materials, of the diagonal of the stiffness in `relaxed` to Young's moduli [1]:
/// 1.35 at a Poisson ratio of 0.3, 1667 at 0.4999.
double stiffening_of_relaxed(const Scene& scene);
/// Beyond this factor forces, stress and modulus of `relaxed` mean nothing.
inline constexpr double largest_stiffening = 2;
/// Whether an answer's reactions make a modulus of the matter: not those of moves that limits cut, nor
/// those of `relaxed` where it is more than twice too stiff.
bool has_modulus(const Scene& scene, const Answer& answer);

/// What a method's reactions make of the test.
struct TestResult {
  double reaction =
      0; ///< on what is moved, along the displacement [N], in 2D per metre; of `bend` the moment [N m]
  double stiffness = 0; ///< reaction over displacement [N/m], over the angle [N m/rad]
  /// Young's (axial, bend), shear, or confined modulus of a homogeneous body that answers as this one; of an
  /// indenter F / (2 R d), which on a half-space is E / (1 - nu^2) [Pa]. Unset in 2D for indent
  std::optional<double> apparent_modulus;
  std::optional<double> failure; ///< reaction at which the tissue fails [N]; where asked for and known
};

/// @param answer its reactions, in the order of scene.prescribed
/// @return nothing without a test, where nothing is moved, or for an answer that knows no forces
/// Cost    O(prescribed); of a failure load O(cells log cells)
/// Source  Sneddon 1965 (flat punch); Pistoia et al. 2002, Bone 30:842 (failure)
/// Checked by  tests/deform/standard_test_test.cpp
std::optional<TestResult> test_result(const Scene& scene, const Answer& answer);

} // namespace maille
