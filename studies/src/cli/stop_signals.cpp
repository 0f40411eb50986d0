#include "cli/commands.hpp"

#include "maille/fem_ref/abandoned.hpp"
#include "maille/studies/export/whole_file.hpp"

#include <array>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>

namespace maille::studies {
namespace {

std::atomic<bool> is_heard{false}, is_asked{false};
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler may touch it");

/// What follows within this time means the same: timeout and mpirun send a signal to a process and to its
/// group, a session that ends sends SIGHUP and SIGTERM.
constexpr long same_wish_ns = 200'000'000;
timespec first_wish{};

void end_by(int signal) {
  remove_unfinished_files();
  struct sigaction usual {};
  usual.sa_handler = SIG_DFL;
  sigaction(signal, &usual, nullptr);
  raise(signal); // as soon as the handler returns
}

void on_stop(int signal) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now); // a handler may call it
  if (!is_heard)
    end_by(signal);
  else if (!is_asked) {
    first_wish = now;
    is_asked = true;
  } else if ((now.tv_sec - first_wish.tv_sec) * 1'000'000'000L + now.tv_nsec - first_wish.tv_nsec >
             same_wish_ns)
    end_by(signal);
}

} // namespace

void catch_stop_signals() {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction now {};
    if (sigaction(signal, nullptr, &now) == 0 && signal == SIGHUP && now.sa_handler == SIG_IGN)
      continue;
    struct sigaction ours {};
    ours.sa_handler = on_stop;
    ours.sa_flags = SA_RESTART;
    for (const int other : {SIGINT, SIGTERM, SIGHUP})
      sigaddset(&ours.sa_mask, other);
    sigaction(signal, &ours, nullptr);
  }
}

void hear_stop_signals() {
  is_heard = true;
}

bool is_stop_asked() {
  return is_asked;
}

int leave(int exit_code) {
  if (fem_ref::works_left_behind() == 0)
    return exit_code;
  std::fflush(nullptr);
  std::_Exit(exit_code);
}

} // namespace maille::studies
