

#include "study/worker_pool.hpp"

#include "export/whole_file.hpp"

#include <fmt/format.h>
#include <poll.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <memory>
#include <optional>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/wait.h>
#include <system_error>
#include <thread>
#include <unistd.h>
#include <utility>
#include <vector>

namespace maille::studies {

namespace {

using Work = std::function<std::string(std::size_t, const std::function<bool()>&)>;

std::atomic<bool> told_to_end{false};

/// Processor time for a worker to end by itself.
constexpr long grace_us = 850'000;

void on_terminate(int) {
  told_to_end = true;
  const itimerval timer{{}, {0, grace_us}};
  setitimer(ITIMER_PROF, &timer, nullptr);
}

void on_end_of_grace(int) {
  remove_unfinished_files();
  _exit(1);
}

/// Transfers all bytes; false if the other side has closed. @param some (from, bytes): transfers some of them
/// and returns their number
template<class Byte, class Some>
bool move_all(Byte* at, std::size_t size, const Some& some) {
  while (size > 0) {
    const ssize_t n = some(at, size);
    if (n < 0 && errno == EINTR)
      continue;
    if (n <= 0)
      return false;
    at += n;
    size -= static_cast<std::size_t>(n);
  }
  return true;
}

bool send_all(int socket, const void* data, std::size_t size) {
  return move_all(static_cast<const char*>(data), size,
                  [socket](const char* at, std::size_t n) { return send(socket, at, n, MSG_NOSIGNAL); });
}

bool receive_all(int socket, void* data, std::size_t size) {
  return move_all(static_cast<char*>(data), size,
                  [socket](char* at, std::size_t n) { return recv(socket, at, n, 0); });
}

/// Main loop of a worker: receives a task's number, sends its text, until there are no more.
[[noreturn]] void live(int socket, pid_t parent, const Work& work) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent)
    _exit(1); // the parent died before
  for (const auto& [signal, handler] :
       {std::pair{SIGINT, SIG_IGN}, std::pair{SIGHUP, SIG_IGN}, std::pair{SIGTERM, &on_terminate},
        std::pair{SIGPROF, &on_end_of_grace}}) {
    struct sigaction wanted {}; // the parent handles the first two, and sends the third
    wanted.sa_handler = handler;
    sigaction(signal, &wanted, nullptr);
  }
  const std::function<bool()> should_stop = [] { return told_to_end.load(); };
  std::uint64_t task = 0;
  while (!told_to_end && receive_all(socket, &task, sizeof task)) {
    const std::string text = work(task, should_stop);
    const std::uint64_t size = text.size();
    if (told_to_end || !send_all(socket, &size, sizeof size) || !send_all(socket, text.data(), text.size()))
      break;
  }
  _exit(0); // skips the parent's clean-up
}

/// The parent's end of one worker.
class Worker {
public:
  explicit Worker(const Work& work) {
    std::array<int, 2> ends{};
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0)
      throw std::system_error(errno, std::generic_category(), "cannot start a worker");
    std::fflush(nullptr);
    const pid_t parent = getpid();
    process_ = fork();
    if (process_ == 0) {
      close(ends[0]);
      try {
        live(ends[1], parent, work);
      } catch (...) { // mainly insufficient memory: treated like any death
        _exit(1);
      }
    }
    close(ends[1]);
    socket_ = ends[0];
    if (process_ < 0) {
      close(socket_);
      throw std::system_error(errno, std::generic_category(), "cannot start a worker");
    }
  }
  Worker(const Worker&) = delete;
  Worker& operator=(const Worker&) = delete;
  ~Worker() {
    close(socket_);
    if (is_alive_) {
      kill(process_, SIGKILL);
      wait();
    }
  }

  int socket() const { return socket_; }
  const std::optional<std::size_t>& task() const { return task_; }
  void give(std::size_t task) {
    task_ = task;
    const std::uint64_t number = task;
    send_all(socket_, &number, sizeof number); // reading detects a dead worker
  }
  /// Text of its task, or the reason of its death.
  TaskResult take() {
    TaskResult result{task_.value_or(0), "", ""};
    task_.reset();
    std::uint64_t size = 0;
    if (receive_all(socket_, &size, sizeof size)) {
      result.text.resize(size);
      if (receive_all(socket_, result.text.data(), size))
        return result;
    }
    const int status = wait();
    result.death = WIFSIGNALED(status)
                       ? fmt::format("its process was ended by signal {} ({})", WTERMSIG(status),
                                     strsignal(WTERMSIG(status)))
                       : fmt::format("its process ended with exit code {}", WEXITSTATUS(status));
    return result;
  }
  void ask_to_end() const { kill(process_, SIGTERM); }
  bool is_alive() const { return is_alive_; }

private:
  int wait() {
    int status = 0;
    while (waitpid(process_, &status, 0) < 0 && errno == EINTR) {
    }
    is_alive_ = false;
    return status;
  }

  pid_t process_ = -1;
  int socket_ = -1;
  bool is_alive_ = true;
  std::optional<std::size_t> task_;
};

/// Workers with data to read, after a tenth of a second at most.
std::vector<Worker*> ready(const std::vector<std::unique_ptr<Worker>>& workers) {
  std::vector<pollfd> sockets;
  for (const auto& worker : workers)
    sockets.push_back({worker->socket(), POLLIN, 0});
  std::vector<Worker*> list;
  if (poll(sockets.data(), sockets.size(), 100) > 0)
    for (std::size_t i = 0; i < workers.size(); ++i)
      if (sockets[i].revents != 0 && workers[i]->task())
        list.push_back(workers[i].get());
  return list;
}

/// Ends all workers; a task that completes afterwards is lost.
void end_all(const std::vector<std::unique_ptr<Worker>>& workers) {
  for (const auto& worker : workers)
    worker->ask_to_end();
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  for (const auto& worker : workers)
    for (pollfd socket{worker->socket(), POLLIN, 0};
         poll(&socket, 1, 20) <= 0 && std::chrono::steady_clock::now() < deadline;) {
    }
}

} // namespace

void work_through(std::size_t n_tasks, int n_workers, const Work& work,
                  const std::function<void(const TaskResult&)>& deliver,
                  const std::function<bool()>& should_stop_here) {
  std::vector<std::unique_ptr<Worker>> workers;
  std::size_t next = 0, done = 0;
  const auto start = [&] {
    auto& worker = workers.emplace_back(std::make_unique<Worker>(work));
    worker->give(next++);
  };
  while (next < n_tasks && workers.size() < static_cast<std::size_t>(n_workers))
    start();
  while (done < n_tasks && !should_stop_here()) {
    for (Worker* worker : ready(workers)) {
      deliver(worker->take());
      ++done;
      if (worker->is_alive()) {
        if (next < n_tasks)
          worker->give(next++);
        continue;
      }
      std::erase_if(workers, [&](const auto& other) { return other.get() == worker; });
      if (next < n_tasks)
        start();
    }
  }
  if (done < n_tasks)
    end_all(workers);
}

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

/// Below this share other processes ran; above it the rest may be work of the system.
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
