#pragma once
/// A deformed lattice that moves the voxels of an object.

#include "maille/scene/answer.hpp"

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace maille::render {

/// Cells at rest whose corners move; voxels are visible only in cells that carry them.
struct Lattice {
  Index3 cells{1, 1, 1};
  Vec3 origin{};                     ///< of node 0 at rest, in the object's frame [m]
  Vec3 spacing{1, 1, 1};             ///< [m]
  std::vector<std::uint8_t> carries; ///< per cell: 0 if nothing is visible in it; empty: all carry

  std::int64_t n_cells() const { return std::int64_t{1} * cells[0] * cells[1] * cells[2]; }
  Index3 nodes() const { return {cells[0] + 1, cells[1] + 1, cells[2] + 1}; }
  std::int64_t n_nodes() const { return std::int64_t{1} * (cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1); }
};

/// Positions of the nodes of a lattice, in the object's frame. 16 bytes per node.
class Deformation {
public:
  /// At rest.
  explicit Deformation(std::shared_ptr<const Lattice> lattice);

  const Lattice& lattice() const { return *lattice_; }
  const std::shared_ptr<const Lattice>& shared_lattice() const { return lattice_; }
  /// Positions of all nodes [m]; x fastest. If one differs, the next render casts the object anew.
  void set_positions(std::span<const Vec3> positions);
  void set_position(std::int64_t node, const Vec3& position);
  Vec3 position(std::int64_t node) const;
  /// Increases with every change: Renderer uses it to detect changes.
  std::uint64_t version() const { return version_; }
  const std::vector<std::array<float, 4>>& nodes() const { return nodes_; }
  std::int64_t bytes() const { return static_cast<std::int64_t>(nodes_.size() * sizeof(nodes_[0])); }

private:
  std::shared_ptr<const Lattice> lattice_;
  std::vector<std::array<float, 4>> nodes_;
  std::uint64_t version_ = 0;
};

/// The lattice of a body: its cells of matter and `margin` cells around them for visible tissue without
/// mechanics (skin around a muscle; 1 keeps surfaces smooth).
std::shared_ptr<const Lattice> lattice_of(const Specimen& body, int margin = 1);

/// Maps a body's displacement to its lattice: unchanged at nodes of the body; farther out each node takes the
/// smoothed mean of its neighbours nearer to the body.
/// @param deformation of a lattice from lattice_of(body, ...)
/// Cost  O(nodes of the lattice)
void carry_along(const Specimen& body, const Displacement& displacement, Deformation& deformation);

/// Every `stride`-th node of a body's lattice along each axis, for animation at 1 / stride^3 of the cost.
/// Nodes outside the body take the displacement of its nearest node.
class CoarseCarrier {
public:
  /// @param stride at least 2
  CoarseCarrier(const Specimen& body, int stride);
  const std::shared_ptr<const Lattice>& lattice() const { return lattice_; }
  /// @param deformation of that lattice
  void carry(const Displacement& displacement, Deformation& deformation);

private:
  std::shared_ptr<const Lattice> lattice_;
  std::vector<std::int64_t> node_of_; ///< per lattice node: the node of the body with its displacement
  std::vector<Vec3> at_rest_, positions_;
};

} // namespace maille::render
