#include "elastic/kept_answers.hpp"

#include "control/method.hpp"
#include "elastic/elastic_methods.hpp"
#include "maille/scene/block_frames.hpp"

#include <algorithm>
#include <cstdint>
#include <utility>

namespace maille::deform {

Answer KeptAnswers::answer(const Scene& scene, const Control& control) {
  const bool is_finite = scene.strain == Strain::finite;
  if ((is_finite && keeping_ != Keeping::answers) || !scene.tied.ties.empty())
    return solve_coupled(scene, control);
  FixedMask fixed(scene.specimen.grid, scene.prescribed);
  const bool is_of_body = body_ && body_->is_of(scene);
  const bool is_as_before = is_of_body && fixed == carried_ && reason_of_moves(scene).empty();
  if (!is_as_before && !reason_to_refuse_coupled(scene).empty())
    return solve_coupled(scene, control);
  carried_ = std::move(fixed);
  const Arena::Open open(arena_);
  const int threads = elastic_threads(scene, control);
  if (threads != threads_ || !is_of_body || is_finite != is_finite_)
    body_.reset();
  is_finite_ = is_finite;
  if (!body_) {
    body_ = std::make_unique<KeptBody>(scene, threads);
    body_->begins_anew = keeping_ != Keeping::answers;
    body_->is_for_holds = keeping_ == Keeping::hierarchy_of_holds;
    first_bytes_ = 0;
    threads_ = threads;
  } else
    body_->adopt_materials(scene);
  const std::int64_t kept = arena_.present();
  try {
    Answer answer = solve_carried(scene, control, body_.get());
    if (has_displacement(answer.status)) {
      answer.bytes += kept;
      if (keeping_ != Keeping::answers) // with what is kept as it was made
        answer.bytes = first_bytes_ = std::max(first_bytes_, answer.bytes);
    } else
      body_.reset();
    return answer;
  } catch (...) { // half of what is to be kept may be there
    body_.reset();
    throw;
  }
}

} // namespace maille::deform
