#include "maille/studies/export/whole_file.hpp"

#include "maille/studies/export/unfinished_files.hpp"

#include <fmt/format.h>

#include <cerrno>
#include <fstream>
#include <system_error>
#include <unistd.h>

namespace maille::studies {
namespace fs = std::filesystem;
namespace {

/// Removes the file unless told that it has found its place.
class TemporaryFile {
public:
  explicit TemporaryFile(const fs::path& file)
      : path_(file.parent_path() /
              fmt::format(".{}.{}.part{}", file.stem().string(), getpid(), file.extension().string())),
        unfinished_(path_) {}
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
  fs::path path_;
  UnfinishedFile unfinished_; ///< until it has found its place or is removed
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

} // namespace maille::studies
