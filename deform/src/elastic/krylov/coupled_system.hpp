#pragma once
/// The operator of `coupled`, whichever way it is stored.

#include "elastic/links/penalty_rows.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/scene.hpp"

#include <functional>
#include <vector>

namespace maille::deform {

class CoupledSystem {
public:
  virtual ~CoupledSystem() = default;
  /// forces = K u, everywhere [N]; dense, [component][node].
  virtual void apply(const Displacement& u, Displacement& forces) = 0;
  /// The same only at the nodes of `prescribed`; other entries are unspecified.
  virtual void apply_at(const std::vector<Prescribed>&, const Displacement& u, Displacement& forces) {
    apply(u, forces);
  }

  /// True if it finds directions by a multigrid of its own, which accepts penalties.
  virtual bool finds_directions() const { return false; }
  /// The multigrid's operator is K and these from now on. @pre finds_directions()
  virtual void set_penalties(const List<PenaltyLink>&) {}
  /// direction = about the solution of (K + penalties) direction = residual, 0 where components are
  /// prescribed: conjugate gradients around the multigrid in float32, until the residual in its norm is
  /// `reduction` of what it was. If it is to be one iteration, then one cycle alone.
  /// @param most  iterations
  /// @return iterations
  /// @pre finds_directions() and residual is 0 where components are prescribed
  virtual int find_direction(const Displacement&, int, double, const std::function<bool()>&, Displacement&) {
    return 0;
  }

  /// True if the multigrid's own float32 fields can store a direction and its image.
  virtual bool keeps_directions() const { return false; }
  /// Sums over all components that may move.
  struct Products {
    double curvature = 0; ///< direction . K direction
    double descent = 0;   ///< direction . residual
    double length = 0;    ///< direction . direction

    Products& operator+=(const Products& other) {
      curvature += other.curvature;
      descent += other.descent;
      length += other.length;
      return *this;
    }
  };
  struct KeptDirection {
    int iterations = 0;
    Products products;
  };
  /// As find_direction, but the direction and its image stay here until the multigrid is used again.
  /// @pre keeps_directions()
  virtual KeptDirection keep_direction(const Displacement&, int, double, const std::function<bool()>&) {
    return {};
  }
  /// Entry of the stored direction at a node (dense number).
  virtual double kept(int, std::size_t) const { return 0; }
  /// u += step p, residual -= step K p, with the stored direction p.
  virtual void move_along_kept(double, Displacement&, Displacement&) {}
};

} // namespace maille::deform
