#pragma once
/// Files that are being written, so that a signal that ends the process can take them away.

#include <filesystem>

namespace maille::studies {

/// Knows of a file for as long as it lives. Of more than 16 at a time, or of paths of more than 4095 bytes,
/// it knows nothing.
class UnfinishedFile {
public:
  explicit UnfinishedFile(const std::filesystem::path& file);
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

private:
  int place_ = -1;
};

/// Removes all of them. A signal handler may call it.
void remove_unfinished_files() noexcept;

} // namespace maille::studies
