#include "export/whole_file.hpp"

#include "maille/materials/json.hpp"
#include "maille/materials/text_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <iterator>
#include <map>
#include <mutex>
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
#include <zlib.h>

namespace maille::studies {

namespace fs = std::filesystem;
namespace {

/// A new, empty file of a name that could not be foreseen. Removed unless told that it has found its place.
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

/// Folders that a FolderLock of this process holds, and the files that it wrote there.
struct Guarded {
  std::string stem;                           ///< begins the names of results; empty: warp's names
  std::map<std::string, std::string> digests; ///< of files, from lists of results
};

struct Guard {
  std::mutex busy;
  std::map<fs::path, Guarded> folders;
  std::set<fs::path> written;
};

Guard& guard() {
  static Guard one;
  return one;
}

bool is_guarded_name(const std::string& name, const std::string& stem) {
  static const std::regex of_warp(
      R"((.+_)?((labels_)?warped|labels|pull|push|jacobian|surface(_.*)?)\.[a-z.]+)");
  return stem.empty() ? std::regex_match(name, of_warp) : name.starts_with(stem);
}

std::string beginning(const fs::path& file, char end) {
  std::string line;
  std::ifstream stream(file, std::ios::binary);
  for (char c = 0; line.size() < 4096 && stream.get(c) && c != end;)
    line += c;
  return line;
}

/// PNG and SVG pictures hold their provenance at the end, as other files do at the beginning.
void add_provenance(const fs::path& file) {
  // A chunk tEXt, `Software` and `maille`, before the last one, IEND.
  static constexpr std::string_view chunk("\0\0\0\x0ftEXtSoftware\0maille"
                                          "\x32\x57\x26\x53",
                                          27);
  const std::string ending = file.extension().string();
  if (ending != ".png" && ending != ".svg")
    return;
  std::ifstream stream(file, std::ios::binary);
  std::string text(std::istreambuf_iterator<char>(stream), {});
  const bool is_png = ending == ".png";
  const auto at = is_png ? text.rfind("IEND") : text.rfind("</svg>");
  bool is_whole = at != std::string::npos && at >= 4;
  if (is_whole && is_png)
    text.insert(at - 4, chunk);
  else
    text += "<!-- maille -->\n";
  std::ofstream out(file, std::ios::binary);
  out << text;
  out.close();
  is_whole = is_whole && out.good();
  if (!is_whole)
    throw fs::filesystem_error("cannot write", file, std::make_error_code(std::errc::io_error));
}

/// True of what Maille wrote. Tables cannot say so: they begin as the new table does.
bool may_be_replaced(const fs::path& file, const fs::path& by, const Guarded& guarded) {
  if (has_provenance(file) || fs::file_size(file) == 0)
    return true;
  if (const auto known = guarded.digests.find(file.filename().string());
      known != guarded.digests.end() && known->second == digest_of(file))
    return true;
  const std::string name = file.extension().string();
  std::string head(512, '\0');
  if (gzFile stream = gzopen(file.c_str(), "rb")) { // which reads plain files, too
    head.resize(static_cast<unsigned>(std::max(0, gzread(stream, head.data(), 512))));
    gzclose(stream);
  }
  const auto says = [&](std::string_view text) { return head.find(text) != std::string::npos; };
  if (name == ".json" || name == ".jsonl")
    return says("\"maille\":") || says("\"kind\": \"study\"") ||
           (!by.empty() && (fs::file_size(by) == 0 || beginning(file, ':') == beginning(by, ':')));
  if (name == ".csv")
    return !by.empty() && (fs::file_size(by) == 0 || beginning(file, '\n') == beginning(by, '\n'));
  if (name == ".png" || name == ".svg") {
    std::ifstream stream(file, std::ios::binary);
    stream.seekg(-std::min<std::streamoff>(64, static_cast<std::streamoff>(fs::file_size(file))),
                 std::ios::end);
    head.assign(std::istreambuf_iterator<char>(stream), {});
  }
  return says("maille");
}

/// @throws FolderTaken where the file is in a guarded folder, and a link or another program's
void check_replaced(const fs::path& link, const fs::path& by) {
  std::error_code none;
  const fs::path folder = fs::weakly_canonical(fs::absolute(link).parent_path(), none),
                 file = folder / link.filename();
  const std::scoped_lock lock(guard().busy);
  const auto at = guard().folders.find(folder);
  if (at == guard().folders.end() || !is_guarded_name(link.filename().string(), at->second.stem))
    return;
  if (fs::is_symlink(file, none))
    throw FolderTaken(
        fmt::format("{}: expected no symbolic link under the name of a result, found one", link.string()));
  if (fs::is_regular_file(file, none) && !guard().written.contains(file) && !is_kept_input(file) &&
      !may_be_replaced(file, by, at->second))
    throw FolderTaken(
        fmt::format("{}: expected a file of Maille, or none, found another file", link.string()));
  guard().written.insert(file);
}

} // namespace

void write_whole(const fs::path& link, const std::function<void(const fs::path&)>& write) {
  if (fs::is_symlink(link))
    check_replaced(link, {});
  const fs::path file = behind_links(link);
  if (is_kept_input(file))
    throw fs::filesystem_error("cannot write: this command reads that file", file, std::error_code());
  if (fs::exists(file) && !fs::is_regular_file(file))
    throw fs::filesystem_error("cannot write: not a file", file, std::error_code());
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path{"."};
  if (!fs::is_directory(folder))
    throw fs::filesystem_error("cannot write: no such folder", file, std::error_code());
  TemporaryFile temporary(file);
  write(temporary.path());
  if (fs::is_regular_file(temporary.path()))
    add_provenance(temporary.path());
  check_replaced(link, temporary.path());
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

/// Locks that no other process shares: a signal that ends the process takes them away.
std::map<fs::path, UnfinishedFile>& own_locks() {
  static std::map<fs::path, UnfinishedFile> files;
  return files;
}

/// False where another process has locked the file. Some network folders have no locks: then it is true.
bool lock(int descriptor, short kind) {
  struct flock whole {};
  whole.l_type = kind;
  whole.l_whence = SEEK_SET;
  return fcntl(descriptor, F_SETLK, &whole) == 0 || (errno != EACCES && errno != EAGAIN);
}

/// False where the file was removed, or replaced, since it was opened.
bool is_still_there(int descriptor, const fs::path& file) {
  struct stat ours {
  }, theirs{};
  return fstat(descriptor, &ours) == 0 && lstat(file.c_str(), &theirs) == 0 && ours.st_ino == theirs.st_ino &&
         ours.st_dev == theirs.st_dev;
}

} // namespace

FolderLock::FolderLock(const fs::path& folder, const std::string& stem, Sharing sharing)
    : FolderLock() { // so that what is taken is given back where the rest throws
  take(folder, ".maille.lock", sharing == Sharing::parts ? F_RDLCK : F_WRLCK);
  if (sharing == Sharing::parts)
    take(folder, fmt::format(".{}.lock", stem), F_WRLCK);
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.is_symlink(error) && is_name_of_result(entry.path().filename().string(), stem))
      throw FolderTaken(fmt::format("{}: expected no symbolic link under the name of a result, found one",
                                    entry.path().string()));
  Guarded guarded{stem, {}};
  for (const char* kind : {"run", "compare", "play"}) {
    const fs::path list = folder / fmt::format("{}_{}_results.json", stem, kind);
    try {
      const auto read = parse_json(read_own_text_file(list, "a list of results"), list);
      for (const auto& [name, digest] : read.at("digests").items())
        guarded.digests[name] = digest.get<std::string>();
    } catch (const std::exception&) { // no list, or another program's
      continue;
    }
  }
  const fs::path place = fs::canonical(folder);
  const std::scoped_lock busy(guard().busy);
  guard().folders.insert_or_assign(place, guarded);
  guard().written.clear();
  // Before the work: names that commands are sure to write. Tables are compared when they are written.
  static const std::regex sure(
      R"(\.(vtm|pvd)|_(compare|trade)\.(json|svg|png)|_(run|compare|play)_results\.json)");
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (const std::string name = entry.path().filename().string();
        !stem.empty() && name.starts_with(stem) && std::regex_match(name.substr(stem.size()), sure) &&
        entry.is_regular_file(error) && !is_kept_input(entry.path()) &&
        !may_be_replaced(entry.path(), "", guarded))
      throw FolderTaken(
          fmt::format("{}: expected a file of Maille, or none, found another file", entry.path().string()));
}

void FolderLock::take(const fs::path& folder, const std::string& name, short kind) {
  const fs::path file = folder / name;
  auto& taken = locks_.emplace_back(-1, file);
  do {
    if (taken.first >= 0)
      close(taken.first);
    taken.first = open(file.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (taken.first < 0)
      throw fs::filesystem_error("cannot write", file, std::error_code(errno, std::generic_category()));
    if (!lock(taken.first, kind)) {
      close(std::exchange(taken.first, -1));
      throw FolderTaken(fmt::format("{}: another process is writing into this folder", folder.string()));
    }
  } while (!is_still_there(taken.first, file));
  if (struct stat known{}; kind == F_WRLCK && fstat(taken.first, &known) == 0 && known.st_size == 0)
    own_locks().try_emplace(file, file);
}

FolderLock::~FolderLock() {
  struct stat known {};
  for (const auto& [descriptor, file] : locks_) {
    // The last holder of a shared lock removes its file; a file that is not empty is not a lock of ours.
    if (descriptor < 0)
      continue;
    if (lock(descriptor, F_WRLCK) && fstat(descriptor, &known) == 0 && known.st_size == 0)
      unlink(file.c_str());
    close(descriptor);
    own_locks().erase(file);
  }
}

namespace {

enum State : int { unused, being_filled, known };

struct Place {
  std::atomic<int> state{unused};
  pid_t process = 0; ///< a forked process has its parent's list, too
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
    places[static_cast<std::size_t>(place_)].state = unused;
}

void remove_unfinished_files() noexcept {
  for (const Place& place : places)
    if (place.state == known && place.process == getpid())
      unlink(place.path.data());
}

} // namespace maille::studies
