#pragma once
/// The body of an object in a world: all specimens, and shapes for worlds only (bolts, nuts, washers, pieces
/// of a puzzle).

#include "maille/scene/scene.hpp"
#include "read/reader.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace maille::reader {

/// A right-handed thread about the z axis through the centre of the shape's box [m].
struct Thread {
  double radius = 0; ///< of the bolt, thread included
  double depth = 0;  ///< of the thread, < radius
  double pitch = 0;  ///< height of one turn
  double play = 0;   ///< between a bolt and its nut, across and along the axis
};

/// Materials of shapes, one number per cell of their box: 0, or no_material. A cell belongs to the shape if
/// its centre does. A bolt: a hexagonal head as wide as the box below z = head, and a threaded shaft above.
std::vector<std::uint8_t> bolt_cells(const Grid& box, const Thread& thread, double head);
/// A hexagonal nut as wide as the box. Its thread matches that of a bolt: rotation alone moves it along. At z
/// = 0 its thread starts half a turn from that of a bolt.
std::vector<std::uint8_t> nut_cells(const Grid& box, const Thread& thread);
/// A ring as wide as the box.
std::vector<std::uint8_t> washer_cells(const Grid& box, double hole_radius);
/// Cells from a text drawing, its first line on top: blanks and dots are empty. @pre lines have equal length
std::vector<std::uint8_t> drawn_cells(const std::vector<std::string>& lines);

/// Division of a picture into pieces.
struct PuzzleCut {
  std::array<int, 2> pieces{1, 1}; ///< along x and y
  std::array<int, 2> piece{0, 0};  ///< which of them, counted from the lower left
  bool is_undercut = false;        ///< round tabs on narrower necks in place of bulges
};
/// One piece of a picture that fills the grid: cells store the picture's shade, 0 to 15, not a material.
///
/// Edges have bulges such that each piece can be pushed into place in the plane: pieces of the lowest row are
/// joined along x; pieces above are added along y, with straight edges between neighbours in a row. Undercut
/// pieces can only be inserted along z.
/// @pre the grid has two dimensions or three (a thickness), and cut.piece is one of its pieces
std::vector<std::uint8_t> puzzle_piece_cells(const Grid& picture, const PuzzleCut& cut);

/// `shape` and its keys. @return false if there is no body
bool read_object_body(TableReader& table, const BodyDefaults& defaults, Scene& scene);

} // namespace maille::reader
