#include "study/table_files.hpp"

#include <cerrno>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <unistd.h>

namespace maille::studies {

namespace {

[[noreturn]] void fail(const std::string& what) {
  throw std::system_error(errno, std::generic_category(), what);
}

int open_to_append(const std::filesystem::path& stem, const char* ending) {
  const std::string file = stem.string() + ending;
  const int descriptor = open(file.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (descriptor < 0)
    fail("cannot write " + file);
  return descriptor;
}

void append_whole(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = write(descriptor, text.data(), text.size());
    if (n < 0 && errno != EINTR)
      fail("cannot write the table");
    text.remove_prefix(std::max<ssize_t>(n, 0));
  }
  if (fdatasync(descriptor) != 0 && errno != EINVAL) // a pipe or a device has nothing to synchronise
    fail("cannot write the table");
}

} // namespace

TableAppender::TableAppender(const std::filesystem::path& stem)
    : stem_(stem), lines_(open_to_append(stem, ".jsonl")), csv_(open_to_append(stem, ".csv")),
      has_header_(lseek(csv_, 0, SEEK_END) > 0) {}

TableAppender::~TableAppender() {
  for (const auto& [descriptor, ending] : {std::pair(lines_, ".jsonl"), {csv_, ".csv"}}) {
    if (lseek(descriptor, 0, SEEK_END) == 0) // empty, for example on a full disk
      unlink((stem_.string() + ending).c_str());
    close(descriptor);
  }
}

void TableAppender::append(const std::vector<StudyRow>& rows) {
  std::string lines, csv = rows.empty() ? "" : columns_of_study().csv(rows);
  for (const StudyRow& row : rows)
    lines += json_line(row) + "\n";
  if (has_header_ && !rows.empty())
    csv.erase(0, columns_of_study().csv_header(rows.front()).size());
  append_whole(lines_, lines); // the file that is read back comes first
  append_whole(csv_, csv);
  has_header_ = has_header_ || !rows.empty();
}

} // namespace maille::studies
