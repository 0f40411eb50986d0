#pragma once
/// What an answer says of forces, strain, stress and energy: on what holds and moves the body, in its labels
/// and materials.
///
/// Forces act on the body, in the world's frame. Figures of parts weigh each cell by its volume at rest.
/// Energies are the method's own where it has them, else those of mean strains (energy_is_of_means). Frame
/// and signs: mechanics_conventions(), docs/mechanics.md.

#include "maille/scene/answer.hpp"

#include <memory>
#include <string_view>

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

/// Errors of everything but the displacement, relative to a reference; see docs/mechanics.md. Each is unset
/// if one of the two lacks the figure, or the reference's is at rounding level.
struct MechanicsErrors {
  /// |F - R| / |R| over the resultants of moves, of holds where there is no move.
  std::optional<double> force;
  std::optional<double> strain_energy; ///< |E - R| / R, of Answer::strain_energy
  /// L2 over cells of the difference of their mean tensors, but those of cells_at_edges().
  std::optional<double> strain, stress;
  /// The same of what RecoveredFields makes of both, over eighths of cells; unset where it was not asked for.
  std::optional<double> recovered_stress;
};
/// All but recovered_stress.
MechanicsErrors compare_mechanics(const Scene& scene, const Answer& answer, const Answer& reference);

class RecoveredFields;
struct CellFields;

/// One answer that others are held against: its fields are found once.
class MechanicsReference {
public:
  /// @param scene, reference  must outlive this @param recovers  stress at nodes is compared, too
  MechanicsReference(const Scene& scene, const Answer& reference, bool recovers);
  ~MechanicsReference();
  MechanicsErrors errors_of(const Answer& answer) const;

private:
  const Scene& scene_;
  const Answer& reference_;
  Mechanics resultants_;
  double pulled_ = 0;        ///< sum of the sizes of reactions [N]
  std::vector<bool> counts_; ///< by cell
  std::unique_ptr<const CellFields> fields_;
  std::unique_ptr<const RecoveredFields> recovered_;
};

/// The cells at whose corners the edge of a held or moved region is, where finite elements themselves
/// diverge: a node is on that edge if a link on the body's surface, or links along several axes, join it to
/// nodes that are neither held nor moved. By cell; none in 1D.
std::vector<bool> cells_at_edges(const Scene& scene);

} // namespace maille
