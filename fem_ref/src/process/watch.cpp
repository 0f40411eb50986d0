#include "process/watch.hpp"

namespace maille::fem_ref {

bool Watch::should_stop() {
  if (status_ != Status::done)
    return true;
  if (control_->should_stop())
    status_ = Status::interrupted;
  else if (control_->seconds_budget && seconds() > *control_->seconds_budget)
    status_ = Status::budget_reached;
  return status_ != Status::done;
}

} // namespace maille::fem_ref
