#pragma once
/// Answers of lattice methods: successful ones, and those on several threads.

#include "maille/deform/solve.hpp"
#include "support/kit.hpp"

#include <initializer_list>

namespace maille::test {

/// The answer with status done; any other status ends the test.
inline Answer solved(const Scene& scene, std::string_view method, const Control& control = {}) {
  Answer answer = deform::solve(scene, method, control);
  if (answer.status != Status::done)
    throw std::runtime_error("the answer is not done: " + answer.message);
  return answer;
}

inline Answer on_threads(const Scene& scene, std::string_view method, int threads) {
  Control control;
  control.threads = threads;
  return deform::solve(scene, method, control);
}

/// @param solve  computes the answer on a number of threads
template<class Solve>
void expect_bits_of_any_threads(Solve&& solve, std::initializer_list<int> numbers = {2, 3}) {
  const Answer one = solve(1);
  for (const int threads : numbers) {
    const Answer several = solve(threads);
    EXPECT_EQ(several.displacement, one.displacement) << threads;
    EXPECT_EQ(several.reaction, one.reaction) << threads;
    EXPECT_EQ(several.strain_energy, one.strain_energy) << threads;
    EXPECT_EQ(several.iterations, one.iterations) << threads;
  }
}

inline void expect_bits_of_any_threads(const Scene& scene, std::string_view method,
                                       std::initializer_list<int> numbers = {2, 3}) {
  expect_bits_of_any_threads([&](int threads) { return on_threads(scene, method, threads); }, numbers);
}

} // namespace maille::test
