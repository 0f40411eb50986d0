#pragma once
/// Where a deformable object would pass through itself.

#include "maille/scene/answer.hpp"
#include "maille/scene/link_limits.hpp"
#include "world/occupancy/body_matter.hpp"
#include "world/occupancy/posed_lattice.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace maille::deform {

/// A node of a part of a body's skin that would cross another part of it.
struct SelfHit {
  std::int32_t voxel = 0;   ///< the node
  std::int32_t partner = 0; ///< a node of the other part
  int axis = 0;             ///< of the world, along which the two parts face one another
  int direction = 1;        ///< from the node to the other part along it: -1 or 1
  double time = 0;          ///< of the way, 0 to 1: up to it nothing crosses
};

/// The skin of one body, looked at for places where it crosses itself.
///
/// The skin is made of the outer faces of cells of matter between their corners where they are: segments in
/// two dimensions, two triangles a face in three. A state crosses itself where an edge of the skin passes
/// through a face that is far from it in the body: more than two cells away, going from cell to cell
/// through faces, and comes from outside. What is nearer, or comes from within (matter that is pressed
/// until it turns inside out), is order within the matter, which limits and elasticity keep. A way from one
/// state to another is looked at in steps of a quarter of a cell of matter.
///
/// Cost     none for full boxes that are not slender, or that limits which bind keep in order; else the
///          range of the displacement, and where that is larger than the narrowest gap at rest, a look at
/// every edge of the skin a step
/// Checked by  tests/deform/world/self_contact_test.cpp
class SelfContact {
public:
  /// @param limits null: none bind
  SelfContact(const Specimen& specimen, const PosedLattice& lattice, const BodyMatter& matter,
              const LinkLimits* limits);

  /// Whether parts of the body that are far from one another in it can have come nearer than `margin` [m].
  /// @param displacement component after component of node after node
  bool may_meet(std::span<const double> displacement, double margin) const;
  /// What first crosses on the straight way of all nodes from one state to another. @pre from crosses nothing
  std::vector<SelfHit> find(const PosedLattice& lattice, const Displacement& from,
                            const Displacement& to) const;
  std::int64_t bytes() const;

private:
  struct Face {
    std::array<std::int32_t, 4> node; ///< -1 where there are fewer
    std::int32_t cell;
    double outwards; ///< of its normal at rest: 1 or -1
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
  std::vector<std::array<std::int32_t, 6>> beside_; ///< of a cell of matter, through its faces; -1: nothing
};

} // namespace maille::deform
