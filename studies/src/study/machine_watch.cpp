#include "study/machine_watch.hpp"

#include <cstdlib>
#include <thread>

#include <sys/resource.h>

namespace maille::studies {

namespace {

double processor_seconds() {
  double seconds = 0;
  for (const auto who : {RUSAGE_SELF, RUSAGE_CHILDREN}) {
    rusage usage{};
    getrusage(who, &usage);
    for (const timeval& time : {usage.ru_utime, usage.ru_stime})
      seconds += static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  }
  return seconds;
}

double load_average_now() {
  double load = 0;
  return getloadavg(&load, 1) == 1 ? load : 0;
}

/// Below that something else ran; above it the system's own work may be all there was.
constexpr double least_share = 0.9;

} // namespace

MachineWatch::MachineWatch()
    : processor_start_(processor_seconds()), load_average_(load_average_now()),
      start_(std::chrono::steady_clock::now()) {}

double MachineWatch::processor_share() const {
  const double wall = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  return (processor_seconds() - processor_start_) / wall;
}

bool MachineWatch::was_busy() const {
  return processor_share() < least_share ||
         load_average_ > static_cast<double>(std::thread::hardware_concurrency());
}

} // namespace maille::studies
