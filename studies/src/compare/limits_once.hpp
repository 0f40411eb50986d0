#pragma once
/// What several methods on one question need to know of its limits.

#include "maille/scene/link_limits.hpp"
#include "maille/studies/comparison.hpp"

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// The limits of a question, found once for all methods that feel them, and not at all where none does: the
/// scale of taut limits may take longer than an answer. It is counted in the set-up of every method that
/// needs it.
class LimitsOnce {
public:
  LimitsOnce(const Scene& asked, const std::vector<std::string>& methods) {
    const auto start = std::chrono::steady_clock::now();
    const bool any = std::ranges::any_of(methods, [&](const auto& m) { return feels_limits(asked, m); });
    const bool is_taut = asked.limit_source() == LimitSource::taut;
    if (any && is_taut)
      known_.emplace(with_known_limits(asked));
    if (any || (asked.limits_bind_relaxed() && !is_taut))
      limits_.emplace(known_ ? *known_ : asked);
    has_play_ = !is_taut || taut_scale() > 0;
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  }

  const Scene& known(const Scene& asked) const { return known_ ? *known_ : asked; }
  /// Null where nothing asks for limits, or where taut ones have no scale.
  const LinkLimits* limits() const { return limits_ && has_play_ ? &*limits_ : nullptr; }
  double taut_scale() const { return limits_ ? limits_->taut_scale() : 0; }
  double seconds() const { return known_ ? seconds_ : 0; }

private:
  std::optional<Scene> known_; ///< with the scale of taut limits
  std::optional<LinkLimits> limits_;
  bool has_play_ = true;
  double seconds_ = 0;
};

} // namespace maille::studies
