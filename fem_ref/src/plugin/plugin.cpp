/// Entry point of the shared object maille-fem.so, which contains fem_ref and loads deal.II.

#include "maille/fem_ref/ranks.hpp"
#include "plugin/functions.hpp"

namespace {

using namespace maille;
using fem_ref::Solver;

constexpr fem_ref::Functions functions{
    .start_ranks = fem_ref::start_ranks,
    .agree = fem_ref::agree,
    .ranks = fem_ref::ranks,
    .exchange = fem_ref::exchange,
    .communicator = fem_ref::communicator,
    .abort_ranks = fem_ref::abort_ranks,
    .works_left_behind = fem_ref::works_left_behind,
    .estimate = fem_ref::estimate,
    .new_solver = [](const fem_ref::Options& options) { return new Solver(options); },
    .delete_solver = [](Solver* solver) { delete solver; },
    .solve = [](Solver& solver, const Scene& scene,
                const Control& control) { return solver.solve(scene, control); },
};

} // namespace

extern "C" const void* maille_plugin(std::size_t layout, const void* host);

extern "C" const void* maille_plugin(std::size_t layout, const void*) {
  return layout == fem_ref::functions_layout ? &functions : nullptr;
}
