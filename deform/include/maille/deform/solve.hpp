#pragma once
/// The doors of the product: Scene in, Answer out, once or again and again for a body that stays.
///
/// solve() refuses, chooses, and reports: it checks numbers and memory, turns the scene into the object's
/// frame, splits sliding borders, calls the method, and joins the parts again. ElasticBody keeps set-up and
/// answers between questions about one body.

#include "maille/scene/answer.hpp"

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

namespace maille::deform {

/// Names of the methods here: limits, dijkstra (its oracle), literal, sweep, relaxed, coupled.
const std::vector<std::string_view>& methods();

/// True if the method stays within limits of links: `relaxed` and `coupled` where the scene asks for some,
/// the others of methods() always.
bool feels_limits(const Scene& scene, std::string_view method);

/// Answers `scene` by `method`, within the object's frame (see object_frame): where the moves turn a body
/// that nothing holds, the method works in the turned frame, and its answer is turned with it.
/// @return status refused where the method cannot carry the scene (loads; unknown method), or where it would
///         take more memory than there is, or than Control::bytes_budget: before it takes any
/// Repeatable: same input, same bits, any number of threads.
Answer solve(const Scene& scene, std::string_view method, const Control& control = {});
/// Same, by enum: a typo is a compile error. Refused for methods of other libraries (finite elements).
Answer solve(const Scene& scene, Method method, const Control& control = {});

/// True if the method can use Control::communicator with `n_ranks` ranks. The first rank then holds the whole
/// answer, the others no displacement. The bits equal those of one process.
bool is_for_all_ranks(const Scene& scene, std::string_view method, int n_ranks);

/// What an ElasticBody keeps between answers.
enum class Keeping {
  answers,   ///< all that there is: an answer differs with those before it, within its tolerance
  hierarchy, ///< what is set up, where it is to the bit what would be: an answer knows none before it
  /// The hierarchy of what holds, while what is touched comes and goes: an answer knows none before it, and
  /// is within its tolerance. @pre holds alone keep the body from moving rigidly
  hierarchy_of_holds
};

/// A body that stays while holds, moves, loads and materials change: `coupled`, question after question, each
/// at the price of what has changed. Kept are the operator, its multigrid, the last answers, and the
/// multipliers of links at their limits. A move that goes on as it went begins at its end; fixed components
/// that come and go (contacts), and constants that change within a factor of 2, keep the coarser levels as
/// they are. Whatever else changes is found by comparing: another body is begun anew. At finite strain an
/// answer begins where a polynomial through those before it leads, with their preconditioner.
///
/// Answers are those of solve() to the scene's tolerance, at finite strain on the branch of the last one; the
/// same questions in the same order give the same bits, for any number of threads. At small strain 3D keeps
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
  /// The next answer knows of none before it, and memory is given back.
  void forget();
  /// Kept between answers [bytes].
  std::int64_t bytes() const;

private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

/// The elastic energy of every cell of the grid [J], by what the method minimises, so that they add up to
/// Answer::strain_energy (of `relaxed`, whose weights are float32, to 1e-6); zero without matter. Of other
/// methods Answer::cell_energy.
/// @param answer  of solve(scene, ...)
/// Cost  O(cells); no method computes it by itself
std::vector<double> cell_energies(const Scene& scene, const Answer& answer, int threads = 1);

/// The memory that a method is expected to hold at its peak, at most [bytes]; 0 for a method that is not
/// known.
std::int64_t bytes_needed(const Scene& scene, std::string_view method);
std::int64_t bytes_needed(const Scene& scene, Method method);

} // namespace maille::deform
