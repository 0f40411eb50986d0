#include "study/table_files.hpp"

#include "maille/studies/study_run.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace maille::studies {

namespace {

[[noreturn]] void fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

int open_to_append(const std::filesystem::path& stem, const char* ending) {
  const std::string file = stem.string() + ending;
  const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (descriptor < 0)
    fail("cannot write " + file);
  return descriptor;
}

void append_whole(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = write(descriptor, text.data(), text.size());
    if (n < 0 && errno != EINTR)
      fail("cannot write the table");
    text.remove_prefix(static_cast<std::size_t>(std::max<ssize_t>(n, 0)));
  }
  if (fdatasync(descriptor) != 0 && errno != EINVAL) // a pipe or a device has nothing to synchronise
    fail("cannot write the table");
}

/// False where another process has locked the file.
bool lock(int descriptor) {
  struct flock whole {};
  whole.l_type = F_WRLCK;
  whole.l_whence = SEEK_SET;
  return fcntl(descriptor, F_SETLK, &whole) == 0;
}

/// False where the file was removed, or replaced, since it was opened.
bool is_still_there(int descriptor, const std::filesystem::path& file) {
  struct stat ours {
  }, theirs{};
  return fstat(descriptor, &ours) == 0 && stat(file.c_str(), &theirs) == 0 && ours.st_ino == theirs.st_ino &&
         ours.st_dev == theirs.st_dev;
}

} // namespace

TableLock::TableLock(const std::filesystem::path& stem)
    : file_(stem.parent_path() / fmt::format(".{}.lock", stem.filename().string())) {
  do {
    if (descriptor_ >= 0)
      close(descriptor_);
    descriptor_ = open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (descriptor_ < 0)
      fail("cannot write " + file_.string());
    if (!lock(descriptor_)) {
      close(descriptor_);
      throw TableTaken(fmt::format("{}.jsonl: another process is writing this table", stem.string()));
    }
  } while (!is_still_there(descriptor_, file_));
}

TableLock::~TableLock() {
  unlink(file_.c_str());
  close(descriptor_);
}

TableAppender::TableAppender(const std::filesystem::path& stem)
    : lines_(open_to_append(stem, ".jsonl")), csv_(open_to_append(stem, ".csv")),
      has_header_(lseek(csv_, 0, SEEK_END) > 0) {}

TableAppender::~TableAppender() {
  close(lines_);
  close(csv_);
}

void TableAppender::append(const std::vector<StudyRow>& rows) {
  std::string lines, csv;
  if (!has_header_ && !rows.empty())
    csv = csv_header(rows.front());
  for (const StudyRow& row : rows) {
    lines += json_line(row) + "\n";
    csv += csv_line(row);
  }
  append_whole(lines_, lines); // what is read again comes first
  append_whole(csv_, csv);
  has_header_ = has_header_ || !rows.empty();
}

} // namespace maille::studies
