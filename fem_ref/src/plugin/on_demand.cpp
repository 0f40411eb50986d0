/// fem_ref's public functions for programs that start without deal.II: the first function that needs the
/// plugin opens it. Without the plugin there is one rank and no abandoned work.

#include "maille/fem_ref/ranks.hpp"
#include "plugin/functions.hpp"

#include <atomic>
#include <utility>

namespace maille::fem_ref {
namespace {

std::atomic<const Functions*> opened = nullptr;

const Functions& plugin() {
  static const auto* const functions = static_cast<const Functions*>(
      open_plugin("maille-fem.so", "finite elements (deal.II)", functions_layout));
  opened = functions;
  return *functions;
}

} // namespace

/// Wraps the plugin's Solver, created at the first call.
class Solver::Kept {
public:
  explicit Kept(const Options& options) : solver_(plugin().new_solver(options)) {}
  ~Kept() { plugin().delete_solver(solver_); }
  Kept(const Kept&) = delete;
  Kept& operator=(const Kept&) = delete;
  Result solve(const Scene& scene, const Control& control) {
    return plugin().solve(*solver_, scene, control);
  }

private:
  Solver* solver_;
};

Solver::Solver(Options options) : options_(std::move(options)) {}
Solver::~Solver() = default;

Result Solver::solve(const Scene& scene, const Control& control) {
  if (!kept_)
    kept_ = std::make_unique<Kept>(options_);
  return kept_->solve(scene, control);
}

Result solve(const Scene& scene, const Options& options, const Control& control) {
  return Solver(options).solve(scene, control);
}

Estimate estimate(const Scene& scene, const Options& options) {
  return plugin().estimate(scene, options);
}

void start_ranks() {
  if (announced_ranks() > 1)
    plugin().start_ranks();
}

Ranks ranks() {
  const Functions* const functions = opened;
  return functions == nullptr ? Ranks{} : functions->ranks();
}

std::vector<std::vector<std::byte>> exchange(std::vector<std::vector<std::byte>> to) {
  const Functions* const functions = opened;
  return functions == nullptr ? to : functions->exchange(std::move(to));
}

bool agree(bool on_first) {
  const Functions* const functions = opened;
  return functions == nullptr ? on_first : functions->agree(on_first);
}

Communicator* communicator() {
  const Functions* const functions = opened;
  return functions == nullptr ? nullptr : functions->communicator();
}

void abort_ranks(int exit_code) {
  if (const Functions* const functions = opened)
    functions->abort_ranks(exit_code);
}

int works_left_behind() {
  const Functions* const functions = opened;
  return functions == nullptr ? 0 : functions->works_left_behind();
}

} // namespace maille::fem_ref
