#pragma once
/// Strain and stress at nodes, recovered from those of the cells around them; errors of mechanics.

#include "maille/scene/cell_fields.hpp"
#include "maille/scene/mechanics/mechanics.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace maille {

/// A field that is continuous within every part of the body (the cells of one label and one material) and
/// jumps between parts: a node has a value for each of its parts; the field is multilinear in cells.
///
/// For each component, a polynomial of degree 2 whose cell means fit those of a patch in weighted least
/// squares. The patch has up to 4^dimension cells of the part around the node, joined to it through faces
/// within the patch. Linear fields are exact as far as the part's cells determine them; a part that is one
/// cell thick is constant across. Values that alternate from cell to cell, as pressure does near
/// incompressibility, are smoothed out inside. Components and frame are those of CellFields.
/// Source  Zienkiewicz, Zhu 1992 (patches of superconvergent values), here of cells' means
/// Cost    O(cells), about 10 us each; 100 bytes a node and part; same input, same bits
class RecoveredFields {
public:
  struct Values {
    std::array<double, 6> strain{};
    std::array<double, 6> stress{}; ///< [Pa]
  };

  RecoveredFields(const Scene& scene, const CellFields& cells);
  RecoveredFields(const Scene& scene, const Displacement& displacement)
      : RecoveredFields(scene, cell_fields(scene, displacement)) {}
  RecoveredFields(const Scene& scene, const Answer& answer)
      : RecoveredFields(scene, cell_fields(scene, answer)) {}

  /// Value of the cell's part at a corner. @pre the cell has matter; @param corner by bits x y z
  const Values& at_corner(std::int64_t cell, int corner) const { return values_[place(cell, corner)]; }
  /// @param in_cell  from 0 at its lower to 1 at its upper sides
  Values at(std::int64_t cell, const Vec3& in_cell) const;
  /// Mean over a cell.
  Values mean(std::int64_t cell) const { return at(cell, {0.5, 0.5, 0.5}); }

  /// Values by node of the grid; zero outside the body.
  struct Shown {
    std::vector<std::array<double, 6>> strain, stress;
  };
  /// One value per node: that of the part with most of its cells; of equal ones, the part of the first cell.
  Shown at_nodes() const;

private:
  std::size_t place(std::int64_t cell, int corner) const;

  Grid grid_;
  std::vector<std::int32_t> part_;       ///< of every cell; -1: no matter
  std::vector<std::size_t> first_;       ///< by node, and the end: offsets into the next two
  std::vector<std::int32_t> parts_here_; ///< a node's parts
  std::vector<Values> values_;
};

/// Errors of everything but the displacement, relative to a reference; see docs/mechanics.md. Each is unset
/// if one of the two lacks the figure, or the reference's is at rounding level.
struct MechanicsErrors {
  /// |F - R| / |R| over the resultants of moves, of holds where there is no move.
  std::optional<double> force;
  std::optional<double> strain_energy; ///< |E - R| / R, of Answer::strain_energy
  /// L2 over cells of the difference of mean tensors, except those of cells_at_edges().
  std::optional<double> strain, stress;
  /// The same for RecoveredFields of both, over eighths of cells; unset if not requested.
  std::optional<double> recovered_stress;
};
/// Errors of an answer, without recovered_stress.
MechanicsErrors compare_mechanics(const Scene& scene, const Answer& answer, const Answer& reference);

/// A reference for several answers: its fields are computed once.
class MechanicsReference {
public:
  /// @param scene, reference  must outlive this @param recovers  true: stress at nodes is compared too
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

/// Cells with a corner on the edge of a held or moved region, where finite elements themselves diverge. A
/// node is on that edge if a link on the body's surface, or links along several axes, join it to nodes that
/// are neither held nor moved. By cell; none in 1D.
std::vector<bool> cells_at_edges(const Scene& scene);

} // namespace maille
