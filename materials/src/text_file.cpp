#include "maille/materials/text_file.hpp"

#include "maille/materials/fault.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <random>
#include <system_error>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace maille {

namespace fs = std::filesystem;

std::string read_own_text_file(const fs::path& file, std::string_view what, std::int64_t largest) {
  const auto fail = [&](const std::string& expected, const std::string& found) {
    throw InputError({{file.string(), 0, "", fmt::format("{} {}", what, expected), found}});
  };
  std::ifstream stream(file, std::ios::binary);
  std::string text;
  std::array<char, 1 << 14> part{};
  while (stream) {
    stream.read(part.data(), static_cast<std::streamsize>(part.size()));
    text.append(part.data(), static_cast<std::size_t>(stream.gcount()));
    if (static_cast<std::int64_t>(text.size()) > largest)
      fail(fmt::format("of at most {} bytes", largest), "more");
  }
  std::error_code none;
  if (!stream.is_open() || stream.bad()) // a folder opens, but cannot be read
    fail("that can be read", !text.empty() ? fmt::format("an error of the device after {} bytes", text.size())
                             : !fs::exists(file, none)      ? "no file of that name"
                             : fs::is_directory(file, none) ? "a folder"
                                                            : "a file that cannot be opened");
  return text;
}

namespace {

/// Device and inode: the same for all names and links of a file.
using Identity = std::pair<dev_t, ino_t>;

std::optional<Identity> identity_of(const fs::path& file) {
  struct stat known {};
  if (stat(file.c_str(), &known) != 0 || !S_ISREG(known.st_mode))
    return std::nullopt;
  return Identity(known.st_dev, known.st_ino);
}

struct OpenedRegister {
  std::mutex busy;
  bool keeps_opened = false;
  /// With a name, to detect that the inode number has been reused by another file.
  std::map<Identity, fs::path> inputs;
  std::vector<std::pair<std::string, fs::path>> outputs; ///< option and file
  std::vector<std::set<fs::path>*> lists;
  std::map<fs::path, std::string> pipes; ///< which give their text once, to a command that reads it twice
};

OpenedRegister& opened() {
  static OpenedRegister one;
  return one;
}

} // namespace

std::string read_text_file(const fs::path& file, std::string_view what, std::int64_t largest) {
  note_opened(file);
  std::error_code none;
  if (!opened().keeps_opened || !fs::is_fifo(file, none))
    return read_own_text_file(file, what, largest);
  const std::scoped_lock lock(opened().busy);
  if (!opened().pipes.contains(file))
    opened().pipes[file] = read_own_text_file(file, what, largest);
  return opened().pipes[file];
}

void note_opened(const fs::path& file) {
  const std::optional<Identity> identity = identity_of(file);
  if (!identity)
    return;
  const std::scoped_lock lock(opened().busy);
  std::error_code none;
  fs::path name = fs::absolute(file, none);
  if (none) // the current folder was deleted
    name = file;
  for (std::set<fs::path>* const list : opened().lists)
    list->insert(name);
  if (!opened().keeps_opened)
    return;
  opened().inputs.insert_or_assign(*identity, name);
  for (const auto& [option, output] : opened().outputs)
    if (identity_of(output) == identity)
      throw UsageError(
          fmt::format("{} {}: expected a file that can be written, found one that this command reads", option,
                      output.string()));
}

void keep_opened_files() {
  const std::scoped_lock lock(opened().busy);
  opened().keeps_opened = true;
}

void keep_input(const fs::path& file) {
  const std::optional<Identity> identity = identity_of(file);
  const std::scoped_lock lock(opened().busy);
  if (identity)
    opened().inputs.insert_or_assign(*identity, fs::absolute(file));
}

bool is_kept_input(const fs::path& file) {
  const std::optional<Identity> identity = identity_of(file);
  if (!identity)
    return false;
  const std::scoped_lock lock(opened().busy);
  const auto at = opened().inputs.find(*identity);
  return at != opened().inputs.end() && identity_of(at->second) == identity;
}

void reserve_output(const std::string& option, const fs::path& file) {
  const std::scoped_lock lock(opened().busy);
  std::error_code none;
  const fs::path path = fs::weakly_canonical(fs::absolute(file), none); // empty for a pipe
  for (const auto& [other, known] : opened().outputs)
    if (other != option && !path.empty() && fs::weakly_canonical(known, none) == path)
      throw UsageError(
          fmt::format("{} {}: expected a file of its own, found that of {}", option, file.string(), other));
  opened().outputs.emplace_back(option, fs::absolute(file));
}

OpenedFiles::OpenedFiles() {
  const std::scoped_lock lock(opened().busy);
  opened().lists.push_back(&files_);
}

OpenedFiles::~OpenedFiles() {
  const std::scoped_lock lock(opened().busy);
  std::erase(opened().lists, &files_);
}

std::string name_of_machine() {
  std::array<char, 65> host{};
  gethostname(host.data(), host.size() - 1);
  std::string name(host.data());
  std::replace_if(
      name.begin(), name.end(), [](char c) { return c == '.' || c == '/'; }, '_');
  return name;
}

int create_beside(const fs::path& file, fs::path& temporary) {
  std::random_device lot;
  for (int trial = 0; trial < 100; ++trial) {
    temporary =
        file.parent_path() / fmt::format(".{}.{}.{}-{:08x}.part{}", file.stem().string().substr(0, 160),
                                         getpid(), name_of_machine(), lot(), file.extension().string());
    const int descriptor =
        open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor >= 0)
      return descriptor;
    if (errno != EEXIST)
      break;
  }
  throw fs::filesystem_error("cannot write", file, std::error_code(errno, std::generic_category()));
}

std::string_view trimmed(std::string_view text, std::string_view blanks) {
  const std::size_t first = text.find_first_not_of(blanks);
  if (first == std::string_view::npos)
    return {};
  return text.substr(first, text.find_last_not_of(blanks) - first + 1);
}

} // namespace maille
