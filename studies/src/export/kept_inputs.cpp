#include "maille/studies/export/kept_inputs.hpp"

#include <set>
#include <utility>

#include <sys/stat.h>

namespace maille::studies {

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

} // namespace maille::studies
