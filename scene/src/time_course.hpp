#pragma once
/// The beginning of what changes over the time of a run, as a run of its own; and where the end of a beam is
/// that a [test] bends to an arc of a circle.

#include "maille/scene/scene.hpp"

#include <cmath>

namespace maille {

/// The same up to a time, which becomes 1. @param time 0 to 1
TimeCourse until(const TimeCourse& course, double time);
Drive until(const Drive& drive, double time);

/// How far the middle of the upper face has gone at a fraction of the angle [m].
inline Vec3 end_of_arc(const StandardTest& test, double fraction) {
  const double turned = fraction * test.angle();
  Vec3 end{};
  if (turned == 0)
    return end;
  const double of_length = test.length / turned;
  end[test.axis] = of_length * std::sin(turned) - test.length;
  end[test.along] = of_length * (1 - std::cos(turned));
  return end;
}

} // namespace maille
