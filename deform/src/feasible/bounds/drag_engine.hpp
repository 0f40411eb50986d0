#pragma once
/// The interface of Drag to the engines that move a body.

#include "feasible/bounds/algorithm_sizes.hpp"
#include "maille/deform/drag.hpp"

#include <limits>
#include <memory>
#include <span>
#include <string>

namespace maille::deform {

struct DragHandle {
  std::int64_t node = 0;
  Index3 at{};
  Vec3 value{};  ///< where it is: exact, though the field is rounded
  Vec3 wanted{}; ///< its requested place
  Vec3 target{}; ///< requested; after a move, clipped
  bool is_moving = false;
  /// Intervals that the holds allow, per component.
  Vec3 least{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
             -std::numeric_limits<double>::infinity()};
  Vec3 greatest{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
                std::numeric_limits<double>::infinity()};
};

class DragEngine {
public:
  virtual ~DragEngine() = default;

  /// Prepares a new handle; false if this engine cannot drag it.
  virtual bool take(DragHandle& handle) = 0;
  /// Clips the targets of the moving handles to the other handles, holds and limits, and moves them there.
  /// @return visited nodes or tiles
  virtual std::int64_t move(std::span<DragHandle> handles) = 0;

  virtual double displacement(int component, std::int64_t node) const = 0;
  virtual void copy_to(Displacement& state) const = 0;
  virtual Drag::Residue residue() const = 0;
  virtual const std::string& algorithm() const = 0;
};

/// Closed form and scans. @pre limits.is_homogeneous()
std::unique_ptr<DragEngine> make_homogeneous_drag(const Scene& scene, const LinkLimits& limits, int threads);
/// The wavefront, from a feasible state or from rest.
std::unique_ptr<DragEngine> make_tiled_drag(const Scene& scene, const LinkLimits& limits, int threads,
                                            const Displacement* state = nullptr);

} // namespace maille::deform
