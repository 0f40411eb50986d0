/// Recorded motions of a hand.

#include "fuzzing.hpp"
#include "maille/deform/probe/device.hpp"

#include <cmath>
#include <limits>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace maille;
  return fuzzing::tried([&] {
    const auto motion = deform::parse_recorded_motion(fuzzing::text_of(data, size));
    fuzzing::require(!motion.samples().empty(), "samples");
    double before = -std::numeric_limits<double>::infinity();
    for (const auto& sample : motion.samples()) {
      fuzzing::require(std::isfinite(sample.time) && sample.time > before, "times that rise");
      before = sample.time;
      for (const double time : {sample.time, (sample.time + motion.duration()) / 2})
        for (const double x : motion.at(time).position)
          fuzzing::require(std::isfinite(x), "places that are finite");
    }
  });
}
