#include "maille/studies/export/whole_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <optional>
#include <random>
#include <regex>
#include <set>
#include <string>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace maille::studies {

namespace fs = std::filesystem;
namespace {

/// What a temporary file's name has behind the name of its file: `.17.host-k3f9`, process and machine.
std::string mark_of_process() {
  std::array<char, 65> host{};
  gethostname(host.data(), host.size() - 1);
  std::string name(host.data());
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '.' || c == '/'; }, '_');
  return fmt::format(".{}.{}", getpid(), name);
}

/// A new, empty file that nobody could have put there before. Removed unless told that it has found its
/// place.
class TemporaryFile {
public:
  explicit TemporaryFile(const fs::path& file) {
    std::random_device lot;
    for (int trial = 0; trial < 100; ++trial) {
      path_ = file.parent_path() / fmt::format(".{}{}-{:08x}.part{}", file.stem().string(), mark_of_process(),
                                               lot(), file.extension().string());
      const int descriptor = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
      if (descriptor >= 0) {
        take_over_mode(file, descriptor);
        close(descriptor);
        unfinished_.emplace(path_);
        return;
      }
      if (errno != EEXIST)
        break;
    }
    throw fs::filesystem_error("cannot write", file, std::error_code(errno, std::generic_category()));
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    std::error_code ignored; // there may be nothing to remove, and a destructor has no one to tell
    if (!placed_)
      fs::remove(path_, ignored);
  }
  const fs::path& path() const { return path_; }
  void move_to(const fs::path& file) {
    fs::rename(path_, file);
    placed_ = true;
  }

private:
  /// Who could read and write the file before still can, as far as this user may grant it.
  static void take_over_mode(const fs::path& file, int descriptor) {
    struct stat before {};
    if (stat(file.c_str(), &before) != 0)
      return;
    const bool has_group = fchown(descriptor, static_cast<uid_t>(-1), before.st_gid) == 0;
    fchmod(descriptor, before.st_mode & (has_group ? 0777U : 0707U));
  }

  fs::path path_;
  std::optional<UnfinishedFile> unfinished_; ///< until it has found its place or is removed
  bool placed_ = false;
};

/// Where a chain of symbolic links leads: a rename onto a link would replace the link.
fs::path behind_links(fs::path file) {
  for (int depth = 0; fs::is_symlink(file); ++depth) {
    if (depth == 40)
      throw fs::filesystem_error("cannot write", file,
                                 std::make_error_code(std::errc::too_many_symbolic_link_levels));
    const fs::path target = fs::read_symlink(file);
    file = target.is_absolute() ? target : file.parent_path() / target;
  }
  return file;
}

} // namespace

void write_whole(const fs::path& link, const std::function<void(const fs::path&)>& write) {
  const fs::path file = behind_links(link);
  if (is_kept_input(file))
    throw fs::filesystem_error("cannot write: this run reads that file", file,
                               std::make_error_code(std::errc::file_exists));
  if (fs::exists(file) && !fs::is_regular_file(file))
    throw fs::filesystem_error("cannot write: not a file", file,
                               std::make_error_code(std::errc::not_supported));
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path{"."};
  if (!fs::is_directory(folder))
    throw fs::filesystem_error("cannot write: no such folder", file,
                               std::make_error_code(std::errc::not_a_directory));
  TemporaryFile temporary(file);
  write(temporary.path());
  if (!fs::is_regular_file(temporary.path()))
    throw fs::filesystem_error("cannot write", file, std::make_error_code(std::errc::io_error));
  temporary.move_to(file);
}

void remove_unfinished_files(const fs::path& folder) {
  static const std::regex name(R"(\..*\.(\d{1,9})\.([^.]*)-[0-9a-f]{8}\.part(\..*)?)");
  const std::string mark = mark_of_process(), host = mark.substr(mark.rfind('.') + 1);
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error)) {
    const std::string found = entry.path().filename().string();
    std::smatch parts;
    if (!std::regex_match(found, parts, name) || parts[2] != host || !entry.is_regular_file(error) ||
        entry.is_symlink(error))
      continue;
    if (kill(std::stoi(parts[1]), 0) != 0 && errno == ESRCH)
      fs::remove(entry.path(), error);
  }
}

void write_whole(const fs::path& file, std::string_view text) {
  const auto write = [&](const fs::path& path) {
    errno = 0;
    std::ofstream stream(path, std::ios::binary);
    stream.write(text.data(), static_cast<std::streamsize>(text.size()));
    stream.close();
    if (!stream)
      throw fs::filesystem_error("cannot write", file,
                                 std::error_code(errno != 0 ? errno : EIO, std::generic_category()));
  };
  // A device or a pipe is written to; replacing it by a file would destroy it.
  if (fs::exists(file) && !fs::is_regular_file(file) && !fs::is_directory(file))
    write(file);
  else
    write_whole(file, write);
}

namespace {

/// Device and number: a file's names, and links to it, share them.
using Identity = std::pair<dev_t, ino_t>;

std::set<Identity>& kept() {
  static std::set<Identity> files;
  return files;
}

} // namespace

void keep_input(const std::filesystem::path& file) {
  struct stat known {};
  if (stat(file.c_str(), &known) == 0 && S_ISREG(known.st_mode))
    kept().emplace(known.st_dev, known.st_ino);
}

bool is_kept_input(const std::filesystem::path& file) {
  struct stat known {};
  return stat(file.c_str(), &known) == 0 && kept().contains({known.st_dev, known.st_ino});
}

namespace {

enum State : int { unused, being_filled, known };

struct Place {
  std::atomic<int> state{unused};
  std::array<char, 4096> path{};
};
static_assert(std::atomic<int>::is_always_lock_free, "a signal handler may touch it");

std::array<Place, 16> places;

} // namespace

UnfinishedFile::UnfinishedFile(const std::filesystem::path& file) {
  const std::string path = std::filesystem::absolute(file).string();
  if (path.size() >= places.front().path.size())
    return;
  for (std::size_t i = 0; i < places.size(); ++i)
    if (int expected = unused; places[i].state.compare_exchange_strong(expected, being_filled)) {
      std::fill(std::copy(path.begin(), path.end(), places[i].path.begin()), places[i].path.end(), '\0');
      places[i].state = known;
      place_ = static_cast<int>(i);
      return;
    }
}

UnfinishedFile::~UnfinishedFile() {
  if (place_ >= 0)
    places[static_cast<std::size_t>(place_)].state = unused;
}

void remove_unfinished_files() noexcept {
  for (const Place& place : places)
    if (place.state == known)
      unlink(place.path.data());
}

} // namespace maille::studies
