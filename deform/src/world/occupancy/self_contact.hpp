#pragma once
/// Self-collision of a deformable object.

#include "maille/scene/answer.hpp"
#include "maille/scene/link_limits.hpp"
#include "world/occupancy/body_matter.hpp"
#include "world/occupancy/posed_lattice.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace maille::deform {

/// A node of a part of a body's skin that would cross another part.
struct SelfHit {
  std::int32_t voxel = 0;   ///< the node
  std::int32_t partner = 0; ///< a node of the other part
  int axis = 0;             ///< of the world, along which the two parts face each other
  int direction = 1;        ///< from the node to the other part along it: -1 or 1
  double time = 0;          ///< part of the way without crossings, 0 to 1
};

/// Self-collision detection on the skin of one body.
///
/// The skin consists of the outer faces of cells between their displaced corners: segments in two dimensions,
/// two triangles per face in three. A state crosses itself if an edge of the skin passes from outside through
/// a face that is far from it in the body: more than two cells away, from cell to cell through faces. Nearer
/// crossings, and crossings from inside (matter that is inverted by pressure), are left to limits and
/// elasticity. The path between two states is tested in steps of a quarter of a cell of matter.
/// Cost     none for full boxes that are not slender, or that binding limits prevent from folding; else the
///          range of the displacement, and if that exceeds the narrowest gap at rest, a test of every edge
///          of the skin per step
/// Checked by  tests/deform/world/self_contact_test.cpp
class SelfContact {
public:
  /// @param limits null: none bind
  SelfContact(const Specimen& specimen, const PosedLattice& lattice, const BodyMatter& matter,
              const LinkLimits* limits);

  /// True if parts that are far from each other in the body may be nearer than `margin` [m].
  /// @param displacement component after component of node after node
  bool may_meet(std::span<const double> displacement, double margin) const;
  /// First crossings on the straight paths of all nodes between two states. @pre `from` has no crossings
  std::vector<SelfHit> find(const PosedLattice& lattice, const Displacement& from,
                            const Displacement& to) const;
  std::int64_t bytes() const;

private:
  struct Face {
    std::array<std::int32_t, 4> node; ///< unused: -1
    std::int32_t cell;
    double outwards; ///< sign of its normal at rest: 1 or -1
  };
  struct Edge {
    std::array<std::int32_t, 2> node;
    std::int32_t cell;
  };
  struct Crossing {
    std::int32_t edge, face;
    friend auto operator<=>(const Crossing&, const Crossing&) = default;
  };
  using Places = std::vector<Eigen::Vector3d>;

  void find_neighbours(const Specimen& specimen);
  void find_edges();
  void find_clearance(const Specimen& specimen);
  std::vector<std::int32_t> near(std::int32_t cell) const;
  bool is_near(std::int32_t one, std::int32_t other) const;
  double spread(const PosedLattice& lattice, const Displacement& at) const;
  bool do_cross(const Edge& edge, const Face& face, const Places& at) const;
  std::vector<Crossing> crossings(const Places& at) const;
  Eigen::Vector3d normal(const Face& face, const Places& at) const;
  Eigen::Vector3d from_face_to_edge(const Crossing& crossing, const Places& at) const;
  std::vector<Crossing> from_outside(const Places& at, const Places& before,
                                     std::vector<Crossing>& known) const;
  std::vector<SelfHit> hits_of(const std::vector<Crossing>& crossed, const Places& free, double time) const;

  int dimension_;
  double step_;          ///< a quarter of the least spacing [m]
  double bin_;           ///< edge of the boxes that faces are sorted into [m]
  double clearance_ = 0; ///< between parts far from one another at rest [m]
  bool is_never_ = false;
  std::vector<Face> faces_;
  std::vector<Edge> edges_;
  std::vector<std::array<std::int32_t, 6>> beside_; ///< neighbours of a cell through its faces; -1: none
};

} // namespace maille::deform
