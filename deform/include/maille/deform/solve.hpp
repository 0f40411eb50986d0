#pragma once
/// Entry points of the library: one answer for a scene, or successive answers for the same body.
///
/// solve() checks numbers and memory, turns the scene into the object's frame, splits sliding borders, calls
/// the method, and merges the parts. ElasticBody caches set-up and answers between questions about one body.

#include "maille/scene/answer.hpp"

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

namespace maille::deform {

/// Names of the methods: limits, dijkstra (its reference), literal, sweep, relaxed, coupled.
const std::vector<std::string_view>& methods();

/// True if the method satisfies limits of links: `relaxed` and `coupled` if the scene has such limits, the
/// other methods always.
bool feels_limits(const Scene& scene, std::string_view method);

/// Answers `scene` by `method`, in the object's frame (see object_frame): if the moves rotate a body without
/// holds, the method works in the rotated frame, and its answer is rotated accordingly.
/// @return status refused if the method does not support the scene (loads; unknown method), or if it would
///         take more memory than is available or than Control::bytes_budget, before allocating any
/// Repeatable: same input, same bits, any number of threads.
Answer solve(const Scene& scene, std::string_view method, const Control& control = {});
/// Same, by enum: a typo is a compile error. Refused for methods of other libraries (finite elements).
Answer solve(const Scene& scene, Method method, const Control& control = {});

/// True if the method can use Control::communicator with `n_ranks` ranks. The first rank then holds the whole
/// answer, the others no displacement. The bits equal those of one process.
bool is_for_all_ranks(const Scene& scene, std::string_view method, int n_ranks);

/// Cache policy of an ElasticBody.
enum class Keeping {
  answers,   ///< everything: answers depend on earlier ones, within tolerance
  hierarchy, ///< bit-identical set-up only: answers do not depend on earlier ones
  /// The hierarchy with holds only, while contacts change: answers do not depend on earlier ones, within
  /// tolerance. @pre the holds remove all rigid motions
  hierarchy_of_holds
};

/// Successive answers of `coupled` for one body with varying holds, moves, loads and materials, each at the
/// cost of the changes. Cached are the operator, its multigrid, the last answers, and the multipliers of
/// links at their limits. A move that continues earlier ones starts from a combination of their answers.
/// Changes of fixed components (contacts), and of constants within a factor of 2, keep the coarser levels.
/// All other changes are detected by comparison: another body, or blocks, start anew.
/// answer begins where a polynomial through those before it leads, with their preconditioner.
///
/// Answers equal those of solve() to the scene's tolerance; the same questions in the same order give the
/// same bits, for any number of threads. In 3D all is cached, in 1D and 2D only the answers. Not thread-safe.
/// all, 1D and 2D the answers. Not for two threads at a time.
/// Memory      that of `coupled`, up to four displacements more, and a copy of the body's matter
/// Checked by  tests/deform/elastic_body_test.cpp; figures: `studies/lab/run bodies`
class ElasticBody {
public:
  explicit ElasticBody(Keeping keeping = Keeping::answers);
  ElasticBody(ElasticBody&&) noexcept;
  ElasticBody& operator=(ElasticBody&&) noexcept;
  ~ElasticBody();

  /// As solve(scene, "coupled", control). Answer::seconds are those of this answer.
  Answer answer(const Scene& scene, const Control& control = {});
  /// Clears the cache and frees its memory.
  void forget();
  /// Size of the cache [bytes].
  std::int64_t bytes() const;

private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

/// The elastic energy of every cell of the grid [J], as the method minimises it; the sum is
/// Answer::strain_energy (for `relaxed`, whose weights are float32, to 1e-6); zero without matter. For other
/// methods Answer::cell_energy.
/// @param answer  of solve(scene, ...)
/// Cost  O(cells); no method computes it by itself
std::vector<double> cell_energies(const Scene& scene, const Answer& answer, int threads = 1);

/// Forecast peak memory of a method, an upper bound [bytes]; 0 for an unknown method.
std::int64_t bytes_needed(const Scene& scene, std::string_view method);
std::int64_t bytes_needed(const Scene& scene, Method method);

} // namespace maille::deform
