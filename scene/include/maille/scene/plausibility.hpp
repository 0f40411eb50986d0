#pragma once
/// Whether a question can be answered, and whether it can mean what it says.
///
/// Two kinds of checks. Unusable: numbers that arithmetic cannot carry, and parts that can still move
/// without strain; methods refuse these. Implausible: statements without effect, sizes out of proportion,
/// strains beyond small strain; check, run and Python warn of these and change nothing.

#include "maille/scene/mechanics/mechanics.hpp"

#include <optional>
#include <string>
#include <vector>

namespace maille {

/// How a part of the body can still move rigidly under the scene's conditions, e.g. `piece 2 of 3 (12 cells
/// about (0.01, 0.02, 0) m) can still turn about z`; empty where nothing can.
///
/// A motion without strain is rigid on each piece whose cells are joined through faces (a face carries 1, 2
/// or 4 nodes in 1D, 2D, 3D: enough to make the motions of both cells one), and pieces may share nodes
/// through edges and corners. So the motions of all pieces, made equal at shared nodes and zero at prescribed
/// components, span exactly the null space of the stiffness matrix. Where more than `largest_joint_problem`
/// motions are left in chains of pieces joined through edges and corners only, those are left to the solver
/// to judge. Cost: O(cells).
std::string remaining_rigid_motion(const Scene& scene);

inline constexpr int largest_joint_problem = 600;

/// Numbers other than 0 outside of this range, in SI units, are refused: stiffness times the square of a
/// displacement, in any such units, must stay among the normal numbers of float64.
inline constexpr double least_usable = 1e-60, greatest_usable = 1e60;

/// Names the first number of a scene that no method accepts, e.g. `the spacing along y is nan`; empty if all
/// are usable. Every number must be finite, the spacing and the elastic moduli positive, and sizes (spacing,
/// moduli, density, loads, the largest prescribed displacement) 0 or within the range above. Readers refuse
/// numbers that are not finite.
/// Cost  O(prescribed + loads), and O(cells) where fibres differ or contract
std::string unusable_number(const Scene& scene);

struct WorldScene;

/// A hold, a move, a load or a plate of a test as the scene has it.
struct StatedPart {
  std::string name, where; ///< as in Scene::conditions
  std::int64_t nodes = 0;  ///< that it has first of all conditions
  double area = 0;         ///< of the outer faces between its nodes [m^2], in 2D per metre of thickness
  double share = 0;        ///< its larger side over the body's mean cross-section there [1]
};
/// One each of Scene::conditions, in their order. O(cells + prescribed log prescribed)
std::vector<StatedPart> stated_parts(const Scene& scene);

/// A material as the body has it.
struct MaterialSummary {
  std::string name;
  double least = 0, most = 0; ///< Young's modulus over its axes, and its cells' stiffness [Pa]
  double density = 0;         ///< [kg/m^3]
  std::string fibre;          ///< whose axis 1 it takes, in words
};
std::vector<MaterialSummary> materials_of(const Scene& scene);

/// What of the scene has no effect, loses a part, or is read otherwise than it seems to be written: courses
/// that end at rest, turns beyond small ones, plates that touch little of an uneven end, single nodes, zeros,
/// conditions that others cover, pieces and voxels that are left out, moduli and densities in another unit,
/// gravity that lifts. plausibility() has these, too.
std::vector<std::string> statement_warnings(const Scene& scene);
/// Warns of settings of [relaxation] that none of the methods reads, of `cut` without limits, and of a scene
/// that neither moves nor loads the body.
std::vector<std::string> unused_settings(const Scene& scene, const std::vector<std::string>& methods);
/// The same for a world: warnings of its objects, and objects at its border.
std::vector<std::string> world_warnings(const WorldScene& world);

struct Plausibility {
  Vec3 size{};                 ///< of the box around the matter, along the scene's axes [m]
  double largest_move = 0;     ///< length of the largest prescribed displacement [m]
  double move_over_length = 0; ///< that over the longest side of the box [1]
  std::optional<double>
      mean_strain; ///< see plausibility [1]; unset where moves turn the body, or nothing is moved
  std::optional<double>
      strain_of_loads; ///< largest traction or contraction over the least Young's modulus [1]; unset without
  std::vector<std::string> warnings; ///< in words, empty where all is in proportion
};

/// Looks at the question alone; nothing is solved.
///
/// The mean strain is the largest move over the distance to the nearest node that is held along it (where
/// none is, the difference to the node that moves least, over their distance). It is what the scene asks for
/// on the way, not the strain at a corner.
///
/// Warned of are: a mean strain, or a strain of loads, above 10 %, where small-strain elasticity no longer
/// holds (with frame = "blocks", whose cells turn, of loads above 50 %); a stretch at which a material of
/// the body is known to fail; cells larger than 1 cm and bodies larger than 10 m, as of lengths in another
/// unit than was meant.
/// Cost  O(cells + prescribed components)
Plausibility plausibility(const Scene& scene);

/// What an answer of small-strain elasticity is not to be believed for, in words: strains above 10 % in more
/// than a twentieth of the body, or a node that goes a fifth of the body's length further than anything is
/// moved, as under loads that are too large for its stiffness. Empty where all is in proportion, for methods
/// without stress, with frame = "blocks", and where plausibility() warns of the moves already.
/// @param question of plausibility() @param largest_displacement of a node [m] @param body of mechanics_of()
std::vector<std::string> implausible_answer(const Scene& scene, const Plausibility& question,
                                            const std::string& method, double largest_displacement,
                                            const PartMechanics& body);

/// Fails and empties an answer of elasticity that is no state of a body: in a twentieth of its cells and more
/// a direction is shortened to nothing, or stretched threefold; or, at finite strain, a stress that no matter
/// bears, 1e12 Pa. Cost  O(cells), about 0.5 us each
void fail_where_inside_out(const Scene& scene, Answer& answer);

/// `60 x 20 x 20 mm`, with the unit that suits the largest.
std::string size_in_words(const Scene& scene, const Vec3& size);
/// `2.5 mm`.
std::string length_in_words(double metres);
/// `size 60 x 20 x 20 mm; largest move 6 mm, 10 % of the length; mean strain 10 %`
std::string in_words(const Scene& scene, const Plausibility& found);

} // namespace maille
