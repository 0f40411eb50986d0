#include "cli/commands.hpp"

#include "export/whole_file.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "program.hpp"

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string_view>
#include <sys/time.h>
#include <unistd.h>

namespace maille::studies {
namespace {

std::atomic<bool> is_heard{false}, is_alone{true};
std::atomic<int> asked_by{0}; ///< the first recorded signal; 0: none
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<int>::is_always_lock_free,
              "a signal handler may touch it");

/// Signals within this time count as one: timeout and mpirun send a signal to a process and to its group; a
/// session that ends sends SIGHUP and SIGTERM.
constexpr long same_wish_ns = 200'000'000;
timespec first_wish{};

/// Processor time that the process may use to end by itself, summed over its threads, and minimum wall-clock
/// time, because many threads use up the former at once.
constexpr long grace_us = 700'000, least_grace_ns = 350'000'000, again_us = 50'000;

long since_first_wish_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now); // safe in a signal handler
  return (now.tv_sec - first_wish.tv_sec) * 1'000'000'000L + now.tv_nsec - first_wish.tv_nsec;
}

void limit_grace(long microseconds) {
  const itimerval timer{{0, again_us}, {0, microseconds}};
  setitimer(ITIMER_PROF, &timer, nullptr);
}

/// Ends the process in phases that do not poll is_stop_asked(): drawing, writing, libraries.
void on_end_of_grace(int) {
  // An abandoned factorisation uses processor time, too: allow five more intervals for the rest.
  static int n_more = 5;
  if (since_first_wish_ns() < least_grace_ns || (fem_ref::works_left_behind() > 0 && n_more-- > 0))
    return; // the timer repeats
  remove_unfinished_files();
  constexpr std::string_view message = "maille: interrupted; unfinished files are removed\n";
  static_cast<void>(!write(STDERR_FILENO, message.data(), message.size()));
  _exit(128 + asked_by);
}

void end_by(int signal) {
  remove_unfinished_files();
  end_programs();
  struct sigaction usual {};
  usual.sa_handler = SIG_DFL;
  sigaction(signal, &usual, nullptr);
  raise(signal); // takes effect when the handler returns
}

void on_stop(int signal) {
  if (!is_heard)
    end_by(signal);
  else if (asked_by == 0) {
    clock_gettime(CLOCK_MONOTONIC, &first_wish);
    asked_by = signal;
    end_programs();
    if (is_alone)
      limit_grace(grace_us);
  } else if (since_first_wish_ns() > same_wish_ns)
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
  is_alone = fem_ref::ranks().size == 1; // ranks stop together, between iterations
  std::signal(SIGPROF, on_end_of_grace);
  is_heard = true;
}

int stop_signal() {
  return asked_by;
}

int leave(int exit_code) {
  if (asked_by != 0 && exit_code <= exit_run_failed)
    exit_code = 128 + asked_by;
  if (fem_ref::works_left_behind() == 0)
    return exit_code;
  std::fflush(nullptr);
  std::_Exit(exit_code);
}

} // namespace maille::studies
