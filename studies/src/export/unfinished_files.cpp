#include "maille/studies/export/unfinished_files.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <string>

#include <unistd.h>

namespace maille::studies {
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
