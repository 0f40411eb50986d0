#include "maille/deform/probe/servo_loop.hpp"

#include <cerrno>
#include <chrono>
#include <cmath>
#include <stdexcept>

#ifdef __linux__
#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>
#include <time.h>
#endif

namespace maille::deform {

std::int64_t ServoClock::now() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

void ServoClock::sleep_until(std::int64_t due) {
#ifdef __linux__
  const timespec until{due / 1'000'000'000, due % 1'000'000'000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
#else
  std::this_thread::sleep_until(std::chrono::steady_clock::time_point(std::chrono::nanoseconds(due)));
#endif
}

bool ServoClock::take_priority([[maybe_unused]] double above_others) {
#ifdef __linux__
  prctl(PR_SET_TIMERSLACK, 1ul, 0ul, 0ul, 0ul);
  const int least = sched_get_priority_min(SCHED_FIFO), most = sched_get_priority_max(SCHED_FIFO);
  sched_param priority{};
  priority.sched_priority = least + static_cast<int>(above_others * (most - least));
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &priority) == 0;
#else
  return false;
#endif
}

ServoLoop::ServoLoop(ProbeDevice& device, Probe& probe, const ServoSettings& settings)
    : device_(&device), probe_(&probe), settings_(settings) {
  if (settings.ticks < 1)
    throw std::invalid_argument("ServoLoop: at least one tick");
  report_.samples.resize(settings.ticks); // written now, so that its pages are mapped
  thread_ = std::thread([this] { run(); });
}

ServoLoop::~ServoLoop() {
  stop();
  if (thread_.joinable())
    thread_.join();
}

const ServoReport& ServoLoop::wait() {
  if (thread_.joinable())
    thread_.join();
  return report_;
}

void ServoLoop::run() {
  if (settings_.wants_priority && settings_.in_real_time)
    report_.had_priority = ServoClock::take_priority(0.5);
  const auto period = static_cast<std::int64_t>(std::llround(1e9 * probe_->settings().period));
  const std::int64_t began = ServoClock::now();
  std::int64_t due = began;
  while (report_.ticks < settings_.ticks && !stopping_.load(std::memory_order_relaxed)) {
    if (settings_.in_real_time) {
      due += period;
      ServoClock::sleep_until(due);
    } else {
      due = ServoClock::now();
    }
    tick(began, due);
    if (settings_.in_real_time) {
      const std::int64_t late = (ServoClock::now() - due) / period; // whole periods that have passed
      report_.missed += late;
      due += late * period;
    }
  }
  report_.samples.resize(report_.ticks);
  has_ended_.store(true, std::memory_order_release);
}

void ServoLoop::tick(std::int64_t began, std::int64_t due) {
  const std::int64_t woken = ServoClock::now();
  const ProbeState& state = probe_->tick(device_->read());
  device_->write(state.force);
  const std::int64_t written = ServoClock::now();
  report_.latency.add(written - due);
  report_.work.add(written - woken);
  const double time = settings_.in_real_time ? 1e-9 * static_cast<double>(due - began)
                                             : static_cast<double>(report_.ticks) * probe_->settings().period;
  report_.samples[report_.ticks] = {time, written - due, state};
  ++report_.ticks;
}

} // namespace maille::deform
