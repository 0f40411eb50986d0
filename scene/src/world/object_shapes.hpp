#pragma once
/// The body of an object in a world: what a specimen can be, and shapes that only worlds have (bolts and what
/// goes onto them, pieces of a puzzle).

#include "maille/scene/scene.hpp"
#include "read/reader.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace maille::reader {

/// A right-handed thread about the axis along z through the middle of the shape's box [m].
struct Thread {
  double radius = 0; ///< of the bolt, thread included
  double depth = 0;  ///< of the thread, < radius
  double pitch = 0;  ///< height of one turn
  double play = 0;   ///< between a bolt and its nut, across and along the axis
};

/// Matter of shapes, one number a cell of their box: 0, or no_material. A cell is of the shape if its middle
/// is. A hexagonal head as wide as the box below z = head, and a threaded shaft above it.
std::vector<std::uint8_t> bolt_cells(const Grid& box, const Thread& thread, double head);
/// A hexagonal nut as wide as the box. Its thread meets that of a bolt: it goes on by turning alone. At z = 0
/// it begins half a turn from where that of a bolt does.
std::vector<std::uint8_t> nut_cells(const Grid& box, const Thread& thread);
/// A ring as wide as the box.
std::vector<std::uint8_t> washer_cells(const Grid& box, double hole_radius);
/// Letters of a drawing, its first line on top: blanks and dots are empty. @pre lines are of one length
std::vector<std::uint8_t> drawn_cells(const std::vector<std::string>& lines);

/// How a picture is cut into pieces.
struct PuzzleCut {
  std::array<int, 2> pieces{1, 1}; ///< along x and y
  std::array<int, 2> piece{0, 0};  ///< which of them, counted from the lower left
  bool is_undercut = false;        ///< round tabs on narrower necks in place of bulges
};
/// One piece of a picture that fills the grid: in place of the number of its material a cell carries the
/// picture's shade, from 0 to 15.
///
/// Edges bulge to one side or the other, never so that a piece could not be pushed into its place in the
/// plane: pieces of the lowest row are joined along x, pieces above are put onto them along y, side by side
/// with straight edges. Undercut pieces can only be put into their places along z.
/// @pre the grid has two dimensions or three (a thickness), and cut.piece is one of its pieces
std::vector<std::uint8_t> puzzle_piece_cells(const Grid& picture, const PuzzleCut& cut);

/// `shape` and its keys. @return false where there is no body
bool read_object_body(TableReader& table, const BodyDefaults& defaults, Scene& scene);

} // namespace maille::reader
