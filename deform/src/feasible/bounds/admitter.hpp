#pragma once
/// The arithmetic of admission, whatever finds the paths.

#include "feasible/bounds/admission.hpp"
#include "feasible/bounds/bound_source.hpp"

#include <vector>

namespace maille::deform {

/// Cuts the moves of one component back to what limits and holds admit: see admit(). Allocates only where
/// there are more prescribed values than ever before.
class Admitter {
public:
  Admitter(BoundSource& source, const Grid& grid) : source_(source), grid_(grid) {}

  /// The values of `component` among `prescribed` are changed in place. @return how many were
  std::int64_t admit(int component, std::span<Prescribed> prescribed);
  std::int64_t bytes() const;
  /// The same before anything is asked, for `n` values of which none need be cut.
  static std::int64_t bytes_for(std::int64_t n);

private:
  enum class Kind { any, hold, move };
  void bounds_by(Kind ends, int component, std::span<const Prescribed> prescribed, bool least_too);
  bool can_all_be_met(int component, std::span<const Prescribed> prescribed, double tolerance);
  void cut_at_holds(int component, std::span<Prescribed> prescribed, double tolerance);
  void reconcile_moves(int component, std::span<Prescribed> prescribed, double tolerance);

  BoundSource& source_;
  Grid grid_;
  std::vector<PathEnd> ends_;
  std::vector<std::int64_t> nodes_; ///< of the component's values, in the order of `prescribed`
  std::vector<double> least_, greatest_, requested_;
};

} // namespace maille::deform
