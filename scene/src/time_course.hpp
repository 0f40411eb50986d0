#pragma once
/// Restricts time courses to the start of a run; and the end of a beam that a [test] bends to a circular arc.

#include "maille/scene/scene.hpp"

#include <cmath>

namespace maille {

/// The course up to `time`, rescaled so that `time` becomes 1. @param time 0 to 1
TimeCourse until(const TimeCourse& course, double time);
Drive until(const Drive& drive, double time);

/// Displacement of the centre of the upper face at a fraction of the angle [m].
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
