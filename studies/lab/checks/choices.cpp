#include "checks/random_scene.hpp"

#include <algorithm>

namespace maille::lab {

int Choices::below(int n) {
  const auto size = static_cast<std::uint64_t>(n);
  std::uint64_t value = 0;
  if (replays_) {
    value = made_.size() < given_.size() ? std::min<std::uint64_t>(given_[made_.size()], size - 1) : 0;
  } else { // splitmix64 (Steele, Lea, Flood 2014)
    state_ += 0x9e3779b97f4a7c15ull;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    value = ((z ^ (z >> 31)) >> 32) * size >> 32;
  }
  made_.push_back(static_cast<std::uint32_t>(value));
  return static_cast<int>(value);
}

namespace {

/// One way down, as far as a number of trials goes.
class Shrinking {
public:
  Shrinking(std::vector<std::uint32_t> choices,
            const std::function<bool(const std::vector<std::uint32_t>&)>& fails, int trials)
      : best_(std::move(choices)), fails_(fails), trials_(trials) {}

  std::vector<std::uint32_t> run() {
    while (halve_the_list() || halve_numbers()) {
    }
    return std::move(best_);
  }

private:
  bool take_if_it_fails(std::vector<std::uint32_t> candidate) {
    if (candidate == best_ || trials_-- <= 0 || !fails_(candidate))
      return false;
    best_ = std::move(candidate);
    return true;
  }

  /// The longest beginning that can go without its rest, by halves.
  bool halve_the_list() {
    bool any = false;
    for (std::size_t cut = best_.size() / 2; cut > 0 && trials_ > 0;) {
      std::vector<std::uint32_t> candidate(best_.begin(), best_.end() - static_cast<std::ptrdiff_t>(cut));
      if (take_if_it_fails(std::move(candidate)))
        any = true;
      else
        cut /= 2;
      cut = std::min(cut, best_.size());
    }
    return any;
  }

  bool halve_numbers() {
    bool any = false;
    for (std::size_t i = 0; i < best_.size() && trials_ > 0; ++i) {
      std::vector<std::uint32_t> candidate = best_;
      candidate[i] = 0;
      if (take_if_it_fails(candidate)) {
        any = true;
        continue;
      }
      for (bool smaller = best_[i] > 1; smaller && best_[i] > 1;) {
        candidate = best_;
        candidate[i] /= 2;
        smaller = take_if_it_fails(std::move(candidate));
        any = any || smaller;
      }
    }
    return any;
  }

  std::vector<std::uint32_t> best_;
  const std::function<bool(const std::vector<std::uint32_t>&)>& fails_;
  int trials_;
};

} // namespace

std::vector<std::uint32_t> shrunk(std::vector<std::uint32_t> choices,
                                  const std::function<bool(const std::vector<std::uint32_t>&)>& fails,
                                  int trials) {
  return Shrinking(std::move(choices), fails, trials).run();
}

} // namespace maille::lab
