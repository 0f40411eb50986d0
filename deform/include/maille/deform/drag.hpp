#pragma once
/// Interactive dragging of a body: handles move step by step, at the cost of the changed region.

#include "maille/deform/plan.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/frame.hpp"

#include <memory>
#include <span>
#include <string>

namespace maille::deform {

/// Rule for the rotation of the frame that limits of a dragged body are measured in.
enum class FrameRule {
  fixed, ///< always the frame of the grid
  /// Rotates by fit_frame() of all handles, if the scene has no holds and there are two or more handles.
  follows_handles,
};

/// State of one body between moves, in float32 for uniform limits (see Body), else in whole quanta (see
/// TiledBody). Displacements are from rest, along the grid's axes [m].
///
/// A handle is a node that has been moved. It keeps its place until it is released, and so do the scene's
/// holds; a request is first clipped to them and the limits. The scene's own moves are ignored. Two or more
/// handles that rotate together rotate the body with them and move it with their middle; handles that shift
/// without rotation drag the body behind them, as a single handle does.
///
/// **The model is plastic**: the state depends on the path, without a force back to rest; residue() returns
/// the remaining displacement.
///
/// Closed form for one handle in a homogeneous body, scans for several in a box, else the wavefront.
/// Repeatable  same bits for any number of threads
/// Source      docs/theory.md, Theorems 1 to 4 and 6; docs/limits.md
/// Checked by  tests/deform/feasible/drag_test.cpp, wavefront_drag_test.cpp
class Drag {
public:
  struct Move {
    std::int64_t node = 0;
    Vec3 displacement{}; ///< finite; components beyond the scene's dimension are not used
  };
  struct Step {
    Vec3 displacement{};      ///< of the handle: the request clipped to limits and holds
    bool is_cut = false;      ///< true if the request was clipped
    std::int64_t visited = 0; ///< visited nodes, per component, or visited tiles
  };
  struct Residue {
    double largest = 0; ///< |displacement| of one component [m]
    std::int64_t node = 0;
    int component = 0;
  };

  /// A body at rest. @param limits of `scene`; both must outlive the drag. @param threads at least 1
  Drag(const Scene& scene, const LinkLimits& limits, int threads = 1,
       FrameRule rule = FrameRule::follows_handles);
  Drag(Drag&&) noexcept;
  Drag& operator=(Drag&&) noexcept;
  ~Drag();

  /// Moves a node of the body to a displacement. Components with a hold stay.
  /// Cost  proportional to the changes; only a new handle allocates; O(holds) the first time a handle is
  ///       moved
  Step move_to(std::int64_t node, const Vec3& displacement);
  /// Moves several nodes, each listed once, to displacements at the same time; incompatible requests are
  /// clipped as by clip(). @param clipped as long as `moves`, or empty
  /// @return `visited`, and whether any request was clipped
  Step move_to(std::span<const Move> moves, std::span<Vec3> clipped = {});
  /// Releases a handle; its node stays where it is until other nodes move it.
  void release(std::int64_t node);

  double displacement(int component, std::int64_t node) const;
  Displacement displacement() const;
  /// The same, without allocation, into an earlier displacement of this drag or a zero one.
  void copy_to(Displacement& state) const;
  /// Largest displacement of any node: with all handles back at rest, the residue of the drag. O(nodes)
  Residue residue() const;

  /// Rotation and shift of the whole body.
  const Frame& frame() const;
  /// Algorithm of the last move, in words.
  const std::string& algorithm() const;
  /// Memory held [bytes].
  std::int64_t bytes() const;
  /// The same, array by array, for a body at rest, without constructing it. Moves add a few numbers per
  /// handle and prescribed value, several handles at once two slabs per thread, and the wavefront its links
  /// and the memory of clipping: see plan_limits().
  static Footprint footprint(const Scene& scene, const LinkLimits& limits);

private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

} // namespace maille::deform
