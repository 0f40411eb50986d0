#pragma once
/// Answers of `coupled` to successive questions about one body; set-up is cached.

#include "elastic/krylov/kept_body.hpp"
#include "elastic/model/fixed_mask.hpp"
#include "maille/deform/solve.hpp"

#include <memory>
#include <vector>

namespace maille::deform {

/// Keeps what solve_coupled() sets up for a body for as long as questions are about it: see ElasticBody,
/// whose rules are these; but frames are not turned, and what no method can carry is not refused.
class KeptAnswers {
public:
  explicit KeptAnswers(Keeping keeping) : keeping_(keeping) {}

  Answer answer(const Scene& scene, const Control& control);
  Keeping keeping() const { return keeping_; }
  void forget() {
    body_.reset();
    carried_ = {};
  }
  /// [bytes]
  std::int64_t bytes() const { return body_ ? arena_.present() : 0; }
  /// The same if the question is about the cached body; else 0, because the cache is freed before the new
  /// set-up.
  std::int64_t bytes_of(const Scene& scene) const { return body_ && body_->is_of(scene) ? bytes() : 0; }

private:
  Keeping keeping_;
  Arena arena_;
  std::unique_ptr<KeptBody> body_;
  FixedMask carried_;            ///< of a question that was not refused
  int threads_ = 0;              ///< of its team
  bool is_finite_ = false;       ///< its strain
  std::int64_t first_bytes_ = 0; ///< of answers about it, the most
};

} // namespace maille::deform
