#pragma once
/// Checks whether a scene can be solved, and whether it is plausible.
///
/// Two kinds of checks. Unusable: numbers outside the range of the arithmetic, and parts that can move
/// without strain; methods refuse these. Implausible: settings without effect, sizes out of proportion,
/// strains beyond small strain; check, run and Python print warnings for these.

#include "maille/scene/mechanics/mechanics.hpp"

#include <optional>
#include <string>
#include <vector>

namespace maille {

/// Describes a rigid motion of a part of the body that the scene's conditions allow, e.g. `piece 2 of 3 (12
/// cells about (0.01, 0.02, 0) m) can still turn about z`; empty if none exists.
///
/// A motion without strain is rigid on each piece whose cells are joined through faces (a face has 1, 2 or 4
/// nodes in 1D, 2D, 3D: enough to make the motions of both cells equal). Pieces may share nodes through edges
/// and corners. The motions of all pieces, made equal at shared nodes and zero at prescribed components,
/// therefore span exactly the null space of the stiffness matrix. Chains of pieces joined through edges and
/// corners only, with more than `largest_joint_problem` remaining motions, are not checked here; the solver
/// detects them. Cost: O(cells).
std::string remaining_rigid_motion(const Scene& scene);

inline constexpr int largest_joint_problem = 600;

/// Non-zero numbers outside this range, in SI units, are refused: stiffness times the square of a
/// displacement, in any such units, must stay a normal number of float64.
inline constexpr double least_usable = 1e-60, greatest_usable = 1e60;

/// Names the first number of a scene that no method accepts, e.g. `the spacing along y is nan`; empty if all
/// are usable. Every number must be finite, the spacing and the elastic moduli positive, and sizes (spacing,
/// moduli, density, loads, the largest prescribed displacement) 0 or within the range above. Readers refuse
/// non-finite numbers.
/// Cost  O(prescribed + loads), and O(cells) if fibres differ or contract
std::string unusable_number(const Scene& scene);

struct WorldScene;

/// A hold, a move, a load or a plate of a test, resolved on the scene.
struct StatedPart {
  std::string name, where; ///< as in Scene::conditions
  std::int64_t nodes = 0;  ///< first prescribed by this condition
  double area = 0;         ///< of the outer faces between its nodes [m^2], in 2D per metre of thickness
  double share = 0;        ///< area of its larger side over the mean cross-section of the body there [1]
};
/// One entry per element of Scene::conditions, same order. O(cells + prescribed log prescribed)
std::vector<StatedPart> stated_parts(const Scene& scene);

/// A material as used by the body.
struct MaterialSummary {
  std::string name;
  double least = 0, most = 0; ///< range of Young's modulus over its axes and the stiffness of its cells [Pa]
  double density = 0;         ///< [kg/m^3]
  std::string fibre;          ///< source of its axis 1, in words
};
std::vector<MaterialSummary> materials_of(const Scene& scene);

/// Settings without effect, partly ignored, or easily misread: courses that end at rest, turns beyond small
/// ones, plates that touch little of an uneven end, single nodes, zeros, conditions that others override,
/// pieces and voxels that are left out, moduli and densities in a wrong unit, gravity that lifts.
/// plausibility() includes these.
std::vector<std::string> statement_warnings(const Scene& scene);
/// Warns of settings of [relaxation] that none of the methods reads, of `cut` without limits, and of a scene
/// without moves and loads.
std::vector<std::string> unused_settings(const Scene& scene, const std::vector<std::string>& methods);
/// The same for a world: warnings of its objects, and objects at its border.
std::vector<std::string> world_warnings(const WorldScene& world);

struct Plausibility {
  Vec3 size{};                 ///< of the box around the matter, along the scene's axes [m]
  double largest_move = 0;     ///< length of the largest prescribed displacement [m]
  double move_over_length = 0; ///< that over the longest side of the box [1]
  std::optional<double>
      mean_strain; ///< see plausibility [1]; unset if moves rotate the body, or nothing is moved
  std::optional<double>
      strain_of_loads; ///< largest traction or contraction over least Young's modulus [1]; unset: no loads
  std::vector<std::string> warnings; ///< in words; empty if all is in proportion
};

/// Checks the scene only; nothing is solved.
///
/// The mean strain is the largest move over the distance to the nearest node that is held along it (without
/// such a node: the difference to the node that moves least, over their distance). It is the strain along
/// that path, not the strain at a corner.
///
/// Warnings: a mean strain, or a strain of loads, above 10 %, where small-strain elasticity no longer holds
/// (with frame = "blocks", where cells rotate, a strain of loads above 50 %); a stretch at which a material
/// of the body is known to fail; cells larger than 1 cm and bodies larger than 10 m, which suggest a wrong
/// unit of length.
/// Cost  O(cells + prescribed components)
Plausibility plausibility(const Scene& scene);

/// Reasons not to trust an answer of small-strain elasticity, in words: strains above 10 % in more than a
/// twentieth of the body, or a node that moves a fifth of the body's length further than any prescribed move,
/// as under loads too large for the stiffness. Empty if all is in proportion, for methods without stress,
/// with frame = "blocks", and if plausibility() already warns of the moves.
/// @param question of plausibility() @param largest_displacement of a node [m] @param body of mechanics_of()
std::vector<std::string> implausible_answer(const Scene& scene, const Plausibility& question,
                                            const std::string& method, double largest_displacement,
                                            const PartMechanics& body);

/// Sets an elastic answer to failed and clears it if it is no physical state: in a twentieth of its cells or
/// more a direction is shortened to zero, or stretched threefold. Cost  O(cells), about 0.5 us each
/// bears, 1e12 Pa. Cost  O(cells), about 0.5 us each
void fail_where_inside_out(const Scene& scene, Answer& answer);

/// `60 x 20 x 20 mm`, in the unit that suits the largest.
std::string size_in_words(const Scene& scene, const Vec3& size);
/// `2.5 mm`.
std::string length_in_words(double metres);
/// `size 60 x 20 x 20 mm; largest move 6 mm, 10 % of the length; mean strain 10 %`
std::string in_words(const Scene& scene, const Plausibility& found);

} // namespace maille
