/// Put before the C library (LD_PRELOAD), makes calls on the files of a folder go wrong, at a call of one's
/// choice:
///
///   MAILLE_FAULT=CALL:N:WHAT  CALL: open (for writing), open_to_read, read, write or rename. From the N-th
///   such call on (from 1) it
///                             fails with ENOSPC, EIO, EROFS or ENOENT; or, once, the process is ended by
///                             KILL, in the middle of the call where it writes, or sent INT; SHORT: writes do
///                             half of what they are asked for; END: reads find the end
///   MAILLE_FAULT_UNDER        only files whose path begins so
///   MAILLE_FAULT_COUNT        a file that the numbers of all such calls are written to at the end
///   MAILLE_OPENED             a file that the names of files opened for reading are added to
///
/// Streams of libstdc++ call open and write themselves; so does VTK, but for pictures (fopen, fwrite).

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/uio.h>
#include <unistd.h>

namespace {

template<class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

struct Plan {
  std::string call, what, under;
  long at = 0;
  Plan() {
    const char* fault = std::getenv("MAILLE_FAULT");
    const char* folder = std::getenv("MAILLE_FAULT_UNDER");
    under = folder ? folder : "/";
    const std::string text = fault ? fault : "";
    const std::size_t first = text.find(':'), second = text.find(':', first + 1);
    if (second == std::string::npos)
      return;
    call = text.substr(0, first);
    at = std::atol(text.substr(first + 1, second - first - 1).c_str());
    what = text.substr(second + 1);
  }
};

const Plan& plan() {
  static const Plan one;
  return one;
}

constexpr const char* calls[] = {"open", "open_to_read", "read", "write", "rename"};
std::atomic<long> n_calls[5];

std::atomic<long>& n_calls_of(std::string_view call) {
  std::size_t i = 0;
  while (calls[i] != call)
    ++i;
  return n_calls[i];
}

std::string kept_in(const char* call) {
  return std::string("MAILLE_FAULT_COUNT_") + call;
}

struct Count {
  Count() { // of the program that this process was before
    for (const char* call : calls)
      if (const char* const kept = std::getenv(kept_in(call).c_str()))
        n_calls_of(call) = std::atol(kept);
  }
  ~Count() {
    const char* file = std::getenv("MAILLE_FAULT_COUNT");
    const int descriptor = file ? open(file, O_WRONLY | O_CREAT | O_TRUNC, 0600) : -1;
    if (descriptor < 0)
      return;
    for (const char* call : calls)
      dprintf(descriptor, "%s %ld\n", call, n_calls_of(call).load());
    close(descriptor);
  }
} count_at_the_end;

bool is_ours(const std::string& path) {
  return path.starts_with(plan().under);
}

std::string path_of(int descriptor) {
  char target[4096];
  const std::string link = "/proc/self/fd/" + std::to_string(descriptor);
  const ssize_t n = readlink(link.c_str(), target, sizeof target);
  return n > 0 ? std::string(target, static_cast<std::size_t>(n)) : std::string();
}

enum class Fate { pass, fail, halve, end };

/// What becomes of this call; errno is set where it fails.
Fate fate_of(const char* call, const std::string& path) {
  if (!is_ours(path))
    return Fate::pass;
  const long number = ++n_calls_of(call);
  if (plan().call != call || plan().at <= 0 || number < plan().at)
    return Fate::pass;
  const std::string& what = plan().what;
  if (what == "INT") {
    if (number == plan().at)
      kill(getpid(), SIGINT);
    return Fate::pass;
  }
  if (what == "SHORT")
    return Fate::halve;
  if (what == "END")
    return Fate::end;
  if (what == "KILL")
    return Fate::halve;
  errno = what == "ENOSPC" ? ENOSPC : what == "EROFS" ? EROFS : what == "ENOENT" ? ENOENT : EIO;
  return Fate::fail;
}

void end_if_asked_to() {
  if (plan().what == "KILL")
    raise(SIGKILL);
}

bool opens_to_write(int flags) {
  return (flags & O_ACCMODE) != O_RDONLY;
}

std::string absolute(const char* path) {
  if (path[0] == '/')
    return path;
  char folder[4096];
  return getcwd(folder, sizeof folder) ? std::string(folder) + "/" + path : path;
}

void log_opened(const std::string& path) {
  static auto* const real = next<int(const char*, int, ...)>("open");
  const char* file = std::getenv("MAILLE_OPENED");
  const int descriptor = file && is_ours(path) ? real(file, O_WRONLY | O_CREAT | O_APPEND, 0600) : -1;
  if (descriptor < 0)
    return;
  dprintf(descriptor, "%s\n", path.c_str());
  close(descriptor);
}

/// False where the file is not to be opened.
bool may_open(const char* path, bool to_write) {
  if (!to_write)
    log_opened(absolute(path));
  const Fate fate = fate_of(to_write ? "open" : "open_to_read", absolute(path));
  if (fate == Fate::halve)
    end_if_asked_to();
  return fate != Fate::fail;
}

} // namespace

extern "C" {

int open(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const int mode = va_arg(rest, int); // not used without O_CREAT
  va_end(rest);
  static auto* const real = next<int(const char*, int, ...)>("open");
  return may_open(path, opens_to_write(flags)) ? real(path, flags, mode) : -1;
}

int open64(const char* path, int flags, ...) {
  va_list rest;
  va_start(rest, flags);
  const int mode = va_arg(rest, int);
  va_end(rest);
  static auto* const real = next<int(const char*, int, ...)>("open64");
  return may_open(path, opens_to_write(flags)) ? real(path, flags, mode) : -1;
}

FILE* fopen(const char* path, const char* mode) {
  static auto* const real = next<FILE*(const char*, const char*)>("fopen");
  return may_open(path, std::strpbrk(mode, "wa+") != nullptr) ? real(path, mode) : nullptr;
}

FILE* fopen64(const char* path, const char* mode) {
  static auto* const real = next<FILE*(const char*, const char*)>("fopen64");
  return may_open(path, std::strpbrk(mode, "wa+") != nullptr) ? real(path, mode) : nullptr;
}

ssize_t write(int descriptor, const void* data, size_t size) {
  static auto* const real = next<ssize_t(int, const void*, size_t)>("write");
  const Fate fate = fate_of("write", path_of(descriptor));
  if (fate == Fate::fail)
    return -1;
  const ssize_t n = real(descriptor, data, fate == Fate::halve ? (size + 1) / 2 : size);
  if (fate == Fate::halve)
    end_if_asked_to();
  return n;
}

ssize_t writev(int descriptor, const iovec* parts, int n_parts) {
  static auto* const real = next<ssize_t(int, const iovec*, int)>("writev");
  const Fate fate = fate_of("write", path_of(descriptor));
  if (fate == Fate::fail)
    return -1;
  const ssize_t n = real(descriptor, parts, fate == Fate::halve ? (n_parts + 1) / 2 : n_parts);
  if (fate == Fate::halve)
    end_if_asked_to();
  return n;
}

size_t fwrite(const void* data, size_t size, size_t n_items, FILE* file) {
  static auto* const real = next<size_t(const void*, size_t, size_t, FILE*)>("fwrite");
  const Fate fate = fate_of("write", path_of(fileno(file)));
  if (fate == Fate::fail)
    return 0;
  const size_t n =
      real(data, size, fate == Fate::halve && plan().what == "KILL" ? (n_items + 1) / 2 : n_items, file);
  if (fate == Fate::halve)
    end_if_asked_to();
  return n;
}

ssize_t read(int descriptor, void* data, size_t size) {
  static auto* const real = next<ssize_t(int, void*, size_t)>("read");
  const Fate fate = fate_of("read", path_of(descriptor));
  if (fate == Fate::fail)
    return -1;
  if (fate == Fate::end)
    return 0;
  return real(descriptor, data, size);
}

int rename(const char* from, const char* to) {
  static auto* const real = next<int(const char*, const char*)>("rename");
  const Fate fate = fate_of("rename", absolute(to));
  if (fate == Fate::halve)
    end_if_asked_to();
  return fate == Fate::fail ? -1 : real(from, to);
}

} // extern "C"

/// A command goes on as a Python program: so do the numbers of its calls.
extern "C" int execv(const char* path, char* const* words) noexcept {
  for (const char* call : calls)
    setenv(kept_in(call).c_str(), std::to_string(n_calls_of(call).load()).c_str(), 1);
  return next<int(const char*, char* const*)>("execv")(path, words);
}
