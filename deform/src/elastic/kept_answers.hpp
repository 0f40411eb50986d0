#pragma once
/// Answers of `coupled` to one question after the other, each at the price of what has changed.

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
  /// The same, where the question is about the body that is kept; else 0, for then it is given back before
  /// anything is made.
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
