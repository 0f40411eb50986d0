#pragma once
/// The beginning of what changes over the time of a run, as a run of its own.

#include "maille/scene/scene.hpp"

namespace maille {

/// The same up to a time, which becomes 1. @param time 0 to 1
TimeCourse until(const TimeCourse& course, double time);
Drive until(const Drive& drive, double time);

} // namespace maille
