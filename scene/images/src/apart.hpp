#pragma once
/// Reads untrusted files with libraries that may crash, hang or take all memory: in a separate process with
/// bounded memory and time, whose results come through a pipe. Private to plugins that read images.

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <ctime>
#include <exception>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <utility>

namespace maille::image_formats {

constexpr const char* too_much = "a damaged file, or one that takes more memory or time than its size allows";

/// Limits this process from now on: memory to the present amount plus `always` plus 40 times the file;
/// processor time to a minute plus a second per MB.
inline void bound_memory_and_time(const std::string& file, std::uint64_t always) {
  constexpr std::uint64_t a_byte = 40, seconds = 60, bytes_a_second = 1'000'000;
  std::error_code error;
  const std::uintmax_t found = std::filesystem::file_size(file, error), bytes = error ? 0 : found;
  const auto bound = [](auto resource, std::uint64_t most) {
    rlimit limit{};
    if (getrlimit(resource, &limit) != 0)
      return;
    limit.rlim_cur = std::min<rlim_t>(limit.rlim_max, most);
    setrlimit(resource, &limit);
  };
  bound(RLIMIT_CPU,
        static_cast<std::uint64_t>(std::clock() / CLOCKS_PER_SEC) + seconds + bytes / bytes_a_second);
  std::ifstream pages("/proc/self/statm");
  std::uint64_t data = 0; // the sixth number in the file
  for (int i = 0; i < 6; ++i)
    pages >> data;
  if (pages)
    bound(RLIMIT_DATA, data * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE)) + always + a_byte * bytes);
}

/// Calls move(address, remaining bytes), a system call, until all bytes are moved.
template<class Byte, class Move>
bool move_all(Byte* at, std::size_t left, Move&& move) {
  while (left > 0) {
    const ssize_t done = move(at, left);
    if (done < 0 && errno == EINTR)
      continue;
    if (done <= 0)
      return false;
    at += done;
    left -= static_cast<std::size_t>(done);
  }
  return true;
}

class Pipe {
public:
  Pipe() {
    if (pipe2(ends_.data(), O_CLOEXEC) != 0)
      ends_ = {-1, -1};
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
  ~Pipe() {
    close_end(0);
    close_end(1);
  }
  bool is_open() const { return ends_[0] >= 0; }
  void close_end(std::size_t end) {
    if (ends_[end] >= 0)
      close(ends_[end]);
    ends_[end] = -1;
  }
  bool put(const void* from, std::size_t count) const {
    return move_all(static_cast<const char*>(from), count,
                    [this](const char* at, std::size_t left) { return write(ends_[1], at, left); });
  }
  bool take(void* to, std::size_t count) const {
    return move_all(static_cast<char*>(to), count,
                    [this](char* at, std::size_t left) { return read(ends_[0], at, left); });
  }
  void put_text(const std::string& text) const {
    const std::size_t size = text.size();
    put(&size, sizeof(size));
    put(text.data(), size);
  }
  bool take_text(std::string& text) const {
    std::size_t size = 0;
    if (!take(&size, sizeof(size)) || size > most_bytes)
      return false;
    text.resize(size);
    return take(text.data(), size);
  }

private:
  static constexpr std::size_t most_bytes = std::size_t{1} << 32U;
  std::array<int, 2> ends_{};
};

/// Runs `work` in a separate process; it writes into the pipe, which is read here.
class Apart {
public:
  template<class Work>
  explicit Apart(Work&& work) : child_(pipe.is_open() ? fork() : -1) {
    if (child_ == 0)
      run(work);
    pipe.close_end(1);
  }
  Apart(const Apart&) = delete;
  Apart& operator=(const Apart&) = delete;
  ~Apart() {
    pipe.close_end(0); // stops the writer
    int status = 0;
    while (child_ > 0 && waitpid(child_, &status, 0) < 0 && errno == EINTR) {
    }
  }

  Pipe pipe;

private:
  template<class Work>
  [[noreturn]] void run(Work&& work) {
    for (const int sign : {SIGABRT, SIGPIPE, SIGXCPU})
      std::signal(sign, SIG_DFL);
    constexpr rlimit none{0, 0};
    setrlimit(RLIMIT_CORE, &none);
    if (const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC); nowhere >= 0)
      dup2(nowhere, STDERR_FILENO); // discards assertion messages
    pipe.close_end(0);
    try {
      work(pipe);
    } catch (const std::exception&) { // from the library, or out of memory
      _exit(1);
    }
    _exit(0);
  }
  pid_t child_;
};

} // namespace maille::image_formats
