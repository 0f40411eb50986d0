#pragma once
/// Pieces of a body: cells that are joined through faces.

#include "maille/scene/scene.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace maille {

/// Found from runs of cells along x instead of single cells. Cost: one read per byte, and little per run.
class BodyPieces {
public:
  struct Piece {
    std::int64_t cells = 0, first_cell = 0;
    Index3 lower{}, upper{}; ///< nodes of its bounding box
  };
  /// A maximal run of cells of matter along x.
  struct Run {
    std::int32_t begin = 0, end = 0, piece = 0;
  };

  explicit BodyPieces(const Specimen& body);

  /// Pieces in the order of their first cells.
  const std::vector<Piece>& pieces() const { return pieces_; }
  /// Runs in a row of cells. @param row y + z (cells along y)
  std::span<const Run> runs_of_row(std::int64_t row) const {
    const auto at = static_cast<std::size_t>(row);
    return std::span(runs_).subspan(first_[at], first_[at + 1] - first_[at]);
  }
  std::int64_t n_rows() const { return static_cast<std::int64_t>(first_.size()) - 1; }
  /// Pieces with the node at a corner of a cell, ascending.
  std::vector<std::int32_t> at_node(const Index3& node) const;
  /// The nodes that two or more pieces share, ascending.
  std::vector<std::int64_t> shared_nodes() const;

private:
  void find_runs(const Specimen& body);
  void join();
  void number();
  std::span<const Run> runs_beside(const Index3& node, int side) const;
  void add_shared_nodes_of_row(int y, int z, std::vector<std::int64_t>& nodes) const;

  Grid grid_;
  std::vector<Run> runs_;
  std::vector<std::size_t> first_; ///< first run of each row, and the end
  std::vector<Piece> pieces_;
};

} // namespace maille

namespace maille::reader {

/// Removes the pieces without nodes of `anchors`; names them in scene.left_out.
/// @return number of remaining cells
std::int64_t leave_out_loose_pieces(Scene& scene, const std::vector<std::int64_t>& anchors);

/// Crops the specimen's grid to its matter; the origin is adjusted. @return old position of its first cell
Index3 crop_to_matter(Specimen& specimen);

} // namespace maille::reader
