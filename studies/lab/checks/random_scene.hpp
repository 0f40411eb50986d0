#pragma once
/// Random scenes of every kind that files can ask for, and the numbers that they are made of, so that what
/// breaks can be made smaller without knowing what it is.

#include "maille/scene/scene.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace maille::lab {

/// Draws numbers and remembers them. A maker that asks for nothing else makes the same thing of the same
/// numbers, and of smaller numbers a simpler thing, if it takes 0 for the simplest choice.
class Choices {
public:
  /// New ones. Same seed, same numbers, on any machine.
  explicit Choices(std::uint64_t seed) : state_(seed) {}
  /// Those of before; zeros once they are used up.
  explicit Choices(std::vector<std::uint32_t> given) : given_(std::move(given)), replays_(true) {}

  /// From 0 to n - 1, each as likely. @pre n > 0
  int below(int n);
  /// From 0 to 1, 1 excluded, in steps of 1/1024.
  double uniform() { return below(1024) / 1024.0; }
  /// True in one of n cases.
  bool is_one_in(int n) { return below(n) == n - 1; }
  /// One of a few, the simplest first.
  template<class Value, std::size_t n>
  const Value& one_of(const std::array<Value, n>& values) {
    return values[static_cast<std::size_t>(below(static_cast<int>(n)))];
  }

  const std::vector<std::uint32_t>& made() const { return made_; }

private:
  std::uint64_t state_ = 0;
  std::vector<std::uint32_t> given_;
  bool replays_ = false;
  std::vector<std::uint32_t> made_;
};

/// Smaller choices for which `fails` is still true: halves of the list, then each number 0 or halved, over
/// and over until nothing gets smaller. @param trials how often `fails` is asked at most
std::vector<std::uint32_t> shrunk(std::vector<std::uint32_t> choices,
                                  const std::function<bool(const std::vector<std::uint32_t>&)>& fails,
                                  int trials = 500);

/// A scene in one, two or three dimensions, mostly of a few dozen nodes: box or holed body with islands and
/// bridges, one to three materials of any valid symmetry and contrast, fibres in any direction, limits given,
/// of the materials or taut, some of no width and some far too wide, holds and moves of faces and of single
/// components of nodes, from a millionth of a spacing to a thousand bodies, at times loads. Every number is
/// finite and valid; nothing says that the question has an answer.
Scene random_scene(Choices& choices);

/// The scene as people can read it, some lines.
std::string in_words(const Scene& scene);

} // namespace maille::lab
