/// Atomic writing of files.
///
/// A writer fills a temporary file with an unpredictable name in the final folder. The file gets Maille's
/// mark, is checked against an existing file (check_replaced), and is renamed, which is atomic within a file
/// system. Devices and pipes are written to directly.
///
/// An error deletes the temporary file, and so does a signal, by a list that is safe in a signal handler
/// (UnfinishedFile). After a kill -9 the name contains the process and the machine: the next command on this
/// machine deletes the file if that process no longer exists.
#include "export/whole_file.hpp"

#include "maille/materials/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <optional>
#include <regex>
#include <string>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace maille::studies {

namespace fs = std::filesystem;
namespace {

/// A new, empty file with an unpredictable name; deleted unless it was moved to its final name.
class TemporaryFile {
public:
  explicit TemporaryFile(const fs::path& file) {
    const int descriptor = create_beside(file, path_);
    take_over_mode(file, descriptor);
    close(descriptor);
    unfinished_.emplace(path_);
  }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  ~TemporaryFile() {
    std::error_code ignored; // it may not exist, and a destructor cannot report errors
    if (!placed_)
      fs::remove(path_, ignored);
  }
  const fs::path& path() const { return path_; }
  void move_to(const fs::path& file) {
    fs::rename(path_, file);
    placed_ = true;
  }

private:
  /// Copies mode and group of the replaced file, as far as this user is permitted.
  static void take_over_mode(const fs::path& file, int descriptor) {
    struct stat before {};
    if (stat(file.c_str(), &before) != 0)
      return;
    const bool has_group = fchown(descriptor, static_cast<uid_t>(-1), before.st_gid) == 0;
    fchmod(descriptor, before.st_mode & (has_group ? 0777U : 0707U));
  }

  fs::path path_;
  std::optional<UnfinishedFile> unfinished_; ///< until it is renamed or deleted
  bool placed_ = false;
};

/// Target of a chain of symbolic links: a rename onto a link would replace the link.
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
  if (fs::is_symlink(link))
    check_replaced(link, "");
  const fs::path file = behind_links(link);
  if (is_kept_input(file))
    throw UsageError(file.string() + ": cannot write: this command reads that file");
  if (fs::exists(file) && !fs::is_regular_file(file))
    throw fs::filesystem_error("cannot write: not a file", file, std::error_code());
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path{"."};
  if (!fs::is_directory(folder))
    throw fs::filesystem_error("cannot write: no such folder", file, std::error_code());
  TemporaryFile temporary(file);
  write(temporary.path());
  if (fs::is_regular_file(temporary.path()))
    add_mark(temporary.path());
  std::string head;
  std::getline(std::ifstream(temporary.path(), std::ios::binary), head);
  check_replaced(link, head);
  if (!fs::is_regular_file(temporary.path()))
    throw fs::filesystem_error("cannot write", file, std::make_error_code(std::errc::io_error));
  temporary.move_to(file);
}

void remove_unfinished_files(const fs::path& folder) {
  static const std::regex name(R"(\..*\.(\d{1,9})\.([^.]*)-[0-9a-f]{8}\.part(\..*)?)");
  const std::string host = name_of_machine();
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

std::string message_of(const std::exception& error) {
  std::string text = error.what(); // "filesystem error: cannot write: Permission denied [a] [b]"
  const auto* const of_file = dynamic_cast<const fs::filesystem_error*>(&error);
  constexpr std::string_view begin = "filesystem error: ";
  if (of_file == nullptr || !text.starts_with(begin))
    return text;
  text.erase(0, begin.size());
  for (const fs::path& path : {of_file->path2(), of_file->path1()})
    if (const std::string end = fmt::format(" [{}]", path.string()); text.ends_with(end))
      text.resize(text.size() - end.size());
  if (const std::string none = ": " + std::error_code().message(); text.ends_with(none))
    text.resize(text.size() - none.size());
  return of_file->path1().empty() ? text : fmt::format("{}: {}", of_file->path1().string(), text);
}

namespace {

enum State : int { unused, being_filled, known };

struct Place {
  std::atomic<int> state{unused};
  pid_t process = 0; ///< owner: a forked process inherits its parent's list
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
      places[i].process = getpid();
      places[i].state = known;
      place_ = static_cast<int>(i);
      return;
    }
}

UnfinishedFile::~UnfinishedFile() {
  if (place_ >= 0)
    places[place_].state = unused;
}

void remove_unfinished_files() noexcept {
  for (const Place& place : places)
    if (place.state == known && place.process == getpid())
      unlink(place.path.data());
}

} // namespace maille::studies
