#pragma once
/// Work that libraries do in one piece, for hours maybe, and a caller who can leave it behind.

#include "maille/scene/answer.hpp"

#include <functional>

namespace maille::fem_ref {

/// Runs `work` in a thread of its own while the calling thread asks `control` whether to stop, and reports
/// its progress. Work that has not ended 0.3 s after it was asked to stop is left to itself: it goes on until
/// it hears of it, and its result is lost. Where nobody can ask to stop, or there is no memory for a thread,
/// the calling thread does it.
/// @param work  must not throw. It may outlive the caller: what it uses has to be its own, and the Control
///              that it is given, which lets the calling thread call the caller's functions while that waits,
///              and afterwards says "stop"
/// @return false where the work was left behind; see works_left_behind()
bool run_abandonable(const Control& control, const std::function<void(const Control&)>& work);

} // namespace maille::fem_ref
