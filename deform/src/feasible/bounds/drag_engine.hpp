#pragma once
/// What Drag asks of the ways to move a body.

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
  Vec3 wanted{}; ///< where it was asked to be
  Vec3 target{}; ///< where it shall be; after a move, what limits and holds permit
  bool is_moving = false;
  /// What the holds alone permit, per component.
  Vec3 least{-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
             -std::numeric_limits<double>::infinity()};
  Vec3 greatest{std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity(),
                std::numeric_limits<double>::infinity()};
};

class DragEngine {
public:
  virtual ~DragEngine() = default;

  /// Gets ready for a new handle; false if this way cannot drag it.
  virtual bool take(DragHandle& handle) = 0;
  /// Cuts the targets of the moving handles back to what the others, the holds and the limits permit, and
  /// moves them there. @return nodes or tiles visited
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
