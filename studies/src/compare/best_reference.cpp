#include "compare/methods.hpp"

#include "maille/base/arena.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "maille/scene/refined.hpp"

#include <fmt/format.h>

namespace maille::studies {

namespace {

constexpr int most_halvings = 3;
constexpr double share_of_memory = 0.6;

/// One mesh of the ladder.
struct Rung {
  int degree = 1, halvings = 0;

  std::string words() const {
    constexpr std::array<const char*, most_halvings + 1> times{
        "", " on cells halved once", " on cells halved twice", " on cells halved three times"};
    return fmt::format("fem_q{}{}", degree, times[halvings]);
  }
};

bool is_affordable(const Scene& scene, fem_ref::LinearSolver solver, double seconds) {
  fem_ref::Options options;
  options.degree = 2;
  options.solver = solver;
  const fem_ref::Estimate estimate = fem_ref::estimate(scene, options);
  return fem_ref::agree(estimate.seconds <= seconds &&
                        estimate.bytes <= share_of_memory * static_cast<double>(available_memory()));
}

/// The scene and its refinements, built on demand, finest last.
class Ladder {
public:
  Ladder(const Scene& scene, fem_ref::LinearSolver solver, double seconds) : scene_(scene) {
    rungs_.push_back({1, 0});
    if (!is_affordable(scene, solver, seconds))
      return;
    rungs_.push_back({2, 0});
    // Quadratic elements on the scene's cells need about as many unknowns as linear ones on cells halved
    // once; meshes far too expensive are not built.
    for (int halvings = 1;
         halvings <= most_halvings && static_cast<double>(finest().specimen.grid.n_cells()) < 2e7;
         ++halvings) {
      fine_.push_back(std::make_unique<Scene>(refined(finest())));
      if (!is_affordable(*fine_.back(), solver, seconds)) {
        fine_.pop_back();
        return;
      }
      rungs_.push_back({2, halvings});
    }
  }
  const std::vector<Rung>& rungs() const { return rungs_; }
  /// Answer at the scene's nodes; without nodal stress if the mesh has other nodes.
  Answer answer(const Rung& rung, const Control& control, Methods& methods) const {
    const Scene& asked = rung.halvings == 0 ? scene_ : *fine_[static_cast<std::size_t>(rung.halvings) - 1];
    Answer answer = methods.answer(asked, rung.degree == 1 ? "fem_q1" : "fem_q2", control);
    answer.algorithm = fmt::format("{}: {}", rung.words(), answer.algorithm);
    if (rung.halvings == 0 || !has_displacement(answer.status))
      return answer;
    for (int i = rung.halvings - 1; i >= 0; --i) {
      const Scene& coarse = i == 0 ? scene_ : *fine_[static_cast<std::size_t>(i) - 1];
      bring_to_coarse(coarse, *fine_[i], answer);
    }
    return answer;
  }

private:
  const Scene& finest() const { return fine_.empty() ? scene_ : *fine_.back(); }

  const Scene& scene_;
  std::vector<std::unique_ptr<Scene>> fine_;
  std::vector<Rung> rungs_;
};

} // namespace

BestReference best_reference(const Scene& scene, double seconds, const Control& control, Methods& methods) {
  const Ladder ladder(scene, methods.solver(), seconds);
  const auto& rungs = ladder.rungs();
  BestReference best;
  if (rungs.size() > 1) {
    const Rung& coarser = rungs[rungs.size() - 2];
    const Answer coarse = ladder.answer(coarser, control, methods);
    best.coarser = coarser.words();
    if (coarse.status == Status::interrupted) {
      best.answer = coarse;
      best.answer.method = "best";
      return best;
    }
    best.answer = ladder.answer(rungs.back(), control, methods);
    best.answer.seconds.setup += coarse.seconds.setup; // the cost of the reference includes both
    best.answer.seconds.solve += coarse.seconds.solve;
    if (is_converged(coarse.status) && is_converged(best.answer.status))
      best.estimated_error = compare(scene, coarse.displacement, best.answer.displacement);
  } else {
    best.answer = ladder.answer(rungs.back(), control, methods);
  }
  best.answer.method = "best";
  return best;
}

} // namespace maille::studies
