#pragma once
/// Strain and stress at nodes, recovered from those of the cells around them; what an answer's forces are
/// good for.

#include "maille/scene/cell_fields.hpp"
#include "maille/scene/mechanics/mechanics.hpp"

#include <optional>
#include <string>
#include <vector>

namespace maille {

/// A field that is continuous within every part of the body (the cells of one label and one material) and
/// jumps between parts: at a node a value for each part there, multilinear in cells.
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

  /// As the cell's own part has it. @pre the cell holds matter; @param corner by bits x y z
  const Values& at_corner(std::int64_t cell, int corner) const { return values_[place(cell, corner)]; }
  /// @param in_cell  from 0 at its lower to 1 at its upper sides
  Values at(std::int64_t cell, const Vec3& in_cell) const;
  /// The mean over a cell.
  Values mean(std::int64_t cell) const { return at(cell, {0.5, 0.5, 0.5}); }

  /// Values by node of the grid; zero outside the body.
  struct Shown {
    std::vector<std::array<double, 6>> strain, stress;
  };
  /// One value a node: that of the part which most of its cells are of, of equals of the one whose first cell
  /// comes first.
  Shown at_nodes() const;

private:
  std::size_t place(std::int64_t cell, int corner) const;

  Grid grid_;
  std::vector<std::int32_t> part_;       ///< of every cell; -1: no matter
  std::vector<std::size_t> first_;       ///< of every node and of their end, into the next two
  std::vector<std::int32_t> parts_here_; ///< a node's parts
  std::vector<Values> values_;
};

/// How far the forces on a body are from balance, and what they are not good for.
struct ForceCheck {
  /// What holds, moves and loads together lack: a force, and a moment about the middle of what is held,
  /// of what is moved where nothing is.
  Resultant missing;
  double force_share = 0;  ///< of the largest of their forces, and of a contraction's [1]
  double moment_share = 0; ///< of the moment of holds, or of that of moves and loads, about that middle [1]
  std::vector<std::string> caveats; ///< a sentence each; empty where nothing is wrong
};
/// Nothing for an answer without reactions. Cost  as resultants_of()
std::optional<ForceCheck> check_forces(const Scene& scene, const Answer& answer);

/// Largest ratio, over the materials, of the diagonal of the stiffness in `relaxed` to Young's moduli [1]:
/// 1.35 at a Poisson ratio of 0.3, 1667 at 0.4999.
double stiffening_of_relaxed(const Scene& scene);
/// Whether an answer's reactions make a modulus of the matter: not those of moves that limits cut, nor
/// those of `relaxed` where it is more than twice too stiff.
bool has_modulus(const Scene& scene, const Answer& answer);

} // namespace maille
