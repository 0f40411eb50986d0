#include "elastic/krylov/conjugate_gradients.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

GradientsEnd conjugate_gradients(GradientSpace& space, GradientWatch& watch) {
  double last = 0;
  while (watch.goes_on()) {
    const double now = space.precondition();
    if (!watch.goes_on_from(now))
      break;
    if (!(now > 0) || !std::isfinite(now))
      return GradientsEnd::no_descent;
    const double beta = last > 0 ? std::max(0.0, (now - space.overlap()) / last) : 0;
    const auto step = space.find_step(beta, now);
    if (!step)
      return GradientsEnd::no_curvature;
    space.take_step(*step);
    last = now;
    if (!watch.goes_on_after(*step, now))
      break;
  }
  return GradientsEnd::told;
}

} // namespace maille::deform
