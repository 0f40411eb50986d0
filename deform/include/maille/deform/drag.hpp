#pragma once
/// Interactive dragging of a body: handles move step by step, at the cost of the region that changes.

#include "maille/deform/plan.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/frame.hpp"

#include <memory>
#include <span>
#include <string>

namespace maille::deform {

/// Whether the frame in which a dragged body's limits are measured turns.
enum class FrameRule {
  fixed, ///< it stays that of the grid
  /// It turns as fit_frame says of all handles, where the scene holds nothing and there are two or more
  follows_handles,
};

/// Keeps the state of one body between moves, in float32 where its limits are the same everywhere (see Body),
/// in whole quanta otherwise (see TiledBody). Displacements are from rest, along the grid's axes [m].
///
/// A handle is a node that has been moved. It stays where it was put, and so do the scene's holds, until it
/// is released; a request is clipped to what they and the limits permit before anything moves. The moves that
/// the scene itself prescribes play no part. Two handles or more that turn together turn the body with them
/// and carry it with their middle; handles that are shifted without a turn drag it behind them, as one does.
///
/// **The model is plastic**: the state depends on the path, nothing pulls back to rest; residue() says what
/// stays.
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
    Vec3 displacement{};      ///< where the handle is now: what limits and holds permit of the request
    bool is_cut = false;      ///< true if that is not what was asked
    std::int64_t visited = 0; ///< nodes looked at, one per component, or tiles visited
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

  /// Puts a node of the body at a displacement. Components that a hold keeps there stay.
  /// Cost  what changes; nothing is allocated but for a new handle; O(holds) the first time a handle is moved
  Step move_to(std::int64_t node, const Vec3& displacement);
  /// Puts several nodes, each given once, at displacements at the same time; requests that contradict each
  /// other are cut as clip() cuts them. @param clipped as long as `moves`, or empty
  /// @return `visited`, and whether anything was cut
  Step move_to(std::span<const Move> moves, std::span<Vec3> clipped = {});
  /// Lets a handle go; it stays where it is until something moves it.
  void release(std::int64_t node);

  double displacement(int component, std::int64_t node) const;
  Displacement displacement() const;
  /// The same, into what has been a displacement of this drag before, or is zero: without new memory.
  void copy_to(Displacement& state) const;
  /// The largest displacement of any node: with all handles back home, what the drag left behind. O(nodes)
  Residue residue() const;

  /// How the body has been turned as a whole.
  const Frame& frame() const;
  /// Which way the last move went, in words.
  const std::string& algorithm() const;
  /// Memory held [bytes].
  std::int64_t bytes() const;
  /// The same, array by array, for a body at rest that is not made. Moves add a few numbers a handle and a
  /// prescribed value, several handles at once two slabs a thread, and the wavefront links and what clipping
  /// needs: see plan_limits.
  static Footprint footprint(const Scene& scene, const LinkLimits& limits);

private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

} // namespace maille::deform
