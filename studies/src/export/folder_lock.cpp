/// Folders of results: one process at a time writes to them, and no other program's file is deleted.
///
/// FolderLock holds `.maille.lock` with a system lock, which is released when the process ends; shards of a
/// study share that lock and lock `.STUDY.lock` each. Meanwhile write_whole() calls check_replaced() for
/// every result name in that folder, or in the folder of a .pvtu's pieces below it: a link, or a file that is
/// not Maille's (is_own_result), is an error and is kept.
///
/// Names that a command will certainly write are checked before its work, because an error after an hour is
/// too late. A foreign file under another result name is left alone.
#include "export/whole_file.hpp"
#include "maille/materials/json.hpp"
#include "maille/materials/text_file.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <map>
#include <mutex>
#include <set>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace maille::studies {

namespace fs = std::filesystem;
namespace {

/// A folder locked by this process.
struct Guarded {
  std::string stem;                           ///< prefix of result names; empty: warp's names
  std::map<std::string, std::string> digests; ///< digests of files, from lists of results
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

/// @throws FolderTaken if the result name belongs to a link or to another program's file
void require_own(const fs::path& file, const Guarded& guarded, std::string_view head_of_table = "") {
  std::error_code none;
  if (fs::is_symlink(file, none))
    throw FolderTaken(
        fmt::format("{}: expected no symbolic link under the name of a result, found one", file.string()));
  const auto known = guarded.digests.find(file.filename().string());
  if (fs::is_regular_file(file, none) && !is_kept_input(file) && !is_own_result(file, head_of_table) &&
      (known == guarded.digests.end() || known->second != digest_of(file)))
    throw FolderTaken(
        fmt::format("{}: expected a file of Maille, or none, found another file", file.string()));
}

/// Lock files of this process only: a signal that ends the process deletes them.
std::map<fs::path, UnfinishedFile>& own_locks() {
  static std::map<fs::path, UnfinishedFile> files;
  return files;
}

/// False if another process has locked the file. True on network folders without support for locks.
bool lock(int descriptor, short kind) {
  struct flock whole {};
  whole.l_type = kind;
  whole.l_whence = SEEK_SET;
  return fcntl(descriptor, F_SETLK, &whole) == 0 || (errno != EACCES && errno != EAGAIN);
}

/// False if the file was deleted or replaced since it was opened.
bool is_still_there(int descriptor, const fs::path& file) {
  struct stat ours {
  }, theirs{};
  return fstat(descriptor, &ours) == 0 && lstat(file.c_str(), &theirs) == 0 && ours.st_ino == theirs.st_ino &&
         ours.st_dev == theirs.st_dev;
}

} // namespace

void check_replaced(const fs::path& link, std::string_view head) {
  std::error_code none;
  const fs::path folder = fs::weakly_canonical(fs::absolute(link).parent_path(), none),
                 file = folder / link.filename();
  const std::scoped_lock lock(guard().busy);
  auto at = guard().folders.find(folder);
  std::string name = link.filename().string();
  if (at == guard().folders.end() && name.ends_with(".vtu")) { // a piece
    at = guard().folders.find(folder.parent_path());
    name = folder.filename().string() + ".pvtu";
  }
  if (at == guard().folders.end() || guard().written.contains(file) ||
      !is_name_of_result(name, at->second.stem))
    return;
  // Only study tables have no rows, hence no header.
  require_own(file, at->second, head.empty() ? "study,case," : fmt::format("{}\n", head));
  guard().written.insert(file);
}

FolderLock::FolderLock(const fs::path& folder, const std::string& stem, Sharing sharing,
                       const std::vector<std::string>& sure)
    : FolderLock() { // so that the destructor releases locks if the rest throws
  take(folder, ".maille.lock", sharing == Sharing::parts ? F_RDLCK : F_WRLCK);
  if (sharing == Sharing::parts)
    take(folder, fmt::format(".{}.lock", stem), F_WRLCK);
  Guarded guarded{stem, {}};
  for (const char* kind : {"run", "compare", "play"}) {
    const fs::path list = folder / fmt::format("{}_{}_results.json", stem, kind);
    try {
      const auto read = parse_json(read_own_text_file(list, "a list of results"), list);
      for (const auto& [name, digest] : read.at("digests").items())
        guarded.digests[name] = digest.get<std::string>();
    } catch (const std::exception&) { // not a list, or another program's
      continue;
    }
  }
  for (const std::string& name : sure)
    require_own(folder / (stem + name), guarded);
  const fs::path place = fs::canonical(folder);
  const std::scoped_lock busy(guard().busy);
  guard().folders.insert_or_assign(place, guarded);
  guard().written.clear();
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
    // The last holder of a shared lock deletes its file; a non-empty file is not our lock.
    if (descriptor < 0)
      continue;
    if (lock(descriptor, F_WRLCK) && fstat(descriptor, &known) == 0 && known.st_size == 0)
      unlink(file.c_str());
    close(descriptor);
    own_locks().erase(file);
  }
}

} // namespace maille::studies
