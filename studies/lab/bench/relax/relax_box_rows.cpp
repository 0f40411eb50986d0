#include "bench/relax/relax.hpp"

#include "maille/scene/refined.hpp"

#include <fmt/format.h>

namespace maille::lab {

namespace {

using fem_ref::LinearSolver;

/// Quadratic elements on one lattice, for that lattice and for coarser ones whose nodes it has.
class FineReference {
public:
  FineReference(const BoxQuestion& question, int cells, const Control& control)
      : cells_(cells), question_(question),
        displacement_(
            fem_answer(box_scene(question, cells), LinearSolver::gmg, 2, 1e-6, control).displacement) {}

  /// @pre cells of the reference are those of the lattice times a power of two, or fewer than them: then
  ///      nothing
  Displacement at(int cells) const {
    if (cells > cells_)
      return {};
    Displacement at_nodes = displacement_;
    for (int finer = cells_; finer > cells; finer /= 2)
      at_nodes = at_coarse_nodes(box_scene(question_, finer / 2), box_scene(question_, finer), at_nodes);
    return at_nodes;
  }
  std::string words(int cells) const {
    return cells == cells_ ? "Q2, same cells" : fmt::format("Q2, cells / {}", cells_ / cells);
  }

private:
  int cells_;
  BoxQuestion question_;
  Displacement displacement_;
};

class Boxes {
public:
  Boxes(const BenchOptions& options, BenchReport& report, RelaxFigures& figures)
      : options_(options), sizes_(RelaxSizes::of(options)), report_(report), figures_(figures) {}

  void poke_in_full();
  void poke_nearly_incompressible();
  void stretch();
  void coarsely(const BoxQuestion& question);
  void against_rivals();

private:
  RelaxCase at(const BoxQuestion& question, const FineReference& reference, int cells) {
    return {question, cells, reference.at(cells), reference.words(cells), options_.quick, report_};
  }
  /// `relaxed`, and `coupled` to all tolerances and extrapolated. @return coupled to 1e-3
  Measured lattice(RelaxCase& box) {
    box.relaxed();
    box.coupled(1e-2);
    const Measured coupled = box.coupled(1e-3);
    box.coupled(1e-5);
    extrapolated_ = box.extrapolated();
    return coupled;
  }

  BenchOptions options_;
  RelaxSizes sizes_;
  BenchReport& report_;
  RelaxFigures& figures_;
  Measured extrapolated_; ///< by the last `lattice`
};

void Boxes::poke_in_full() {
  const BoxQuestion question = isotropic_box(BoxLoad::poke, 0.3);
  const FineReference reference(question, sizes_.middle, report_.one_thread());
  RelaxCase small = at(question, reference, sizes_.small);
  const std::int64_t sweeps = small.sweep();
  figures_.coupled_small = lattice(small);
  figures_.extrapolated_small = extrapolated_;
  for (const LinearSolver solver : {LinearSolver::gmg, LinearSolver::cg_amg, LinearSolver::cholmod})
    small.fem_q1(solver);

  RelaxCase middle = at(question, reference, sizes_.middle);
  middle.extrapolated_sweep(sweeps, sizes_.small);
  figures_.coupled_middle = lattice(middle);
  for (const LinearSolver solver : {LinearSolver::gmg, LinearSolver::cg_amg})
    figures_.fem_middle.push_back(middle.fem_q1(solver));

  RelaxCase large(question, sizes_.large, {}, "", options_.quick, report_);
  large.extrapolated_sweep(sweeps, sizes_.small);
  figures_.relaxed_large = large.relaxed();
  large.coupled(1e-2);
  figures_.coupled_large = large.coupled(1e-3);
  figures_.coupled_large_two_threads = large.coupled(1e-3, 2);
}

void Boxes::poke_nearly_incompressible() {
  const BoxQuestion question = isotropic_box(BoxLoad::poke, 0.49);
  const FineReference reference(question, sizes_.middle, report_.one_thread());
  RelaxCase small = at(question, reference, sizes_.small);
  lattice(small);
  small.fem_q1(LinearSolver::gmg);
  RelaxCase middle = at(question, reference, sizes_.middle);
  figures_.coupled_nu49 = lattice(middle);
  figures_.q1_nu49 = middle.fem_q1(LinearSolver::gmg);
}

void Boxes::stretch() {
  const BoxQuestion question = isotropic_box(BoxLoad::stretch, 0.3);
  const FineReference reference(question, sizes_.middle, report_.one_thread());
  RelaxCase pull = at(question, reference, sizes_.pull);
  figures_.coupled_pull = pull.coupled(1e-3);
  pull.extrapolated();
  for (const LinearSolver solver : {LinearSolver::gmg, LinearSolver::cholmod})
    pull.fem_q1(solver);
  RelaxCase small = at(question, reference, sizes_.small);
  const std::int64_t sweeps = small.sweep();
  lattice(small);
  small.fem_q1(LinearSolver::gmg);
  RelaxCase middle = at(question, reference, sizes_.middle);
  middle.extrapolated_sweep(sweeps, sizes_.small);
  figures_.stretch_middle = lattice(middle);
  middle.fem_q1(LinearSolver::gmg);
}

void Boxes::coarsely(const BoxQuestion& question) {
  const FineReference reference(question, sizes_.small, report_.one_thread());
  RelaxCase small = at(question, reference, sizes_.small);
  lattice(small);
  small.fem_q1(LinearSolver::gmg);
}

void Boxes::against_rivals() {
  const BoxQuestion question = isotropic_box(BoxLoad::poke, 0.25); // what springs are
  const FineReference reference(question, sizes_.middle, report_.one_thread());
  RelaxCase middle = at(question, reference, sizes_.middle);
  const Measured coupled = middle.coupled(1e-3);
  bench_rivals(middle.scene(), reference.at(sizes_.middle), coupled, report_, figures_);
}

} // namespace

void bench_boxes(const BenchOptions& options, BenchReport& report, RelaxFigures& figures) {
  Boxes boxes(options, report, figures);
  boxes.poke_in_full();
  boxes.poke_nearly_incompressible();
  boxes.stretch();
  for (const BoxQuestion& question :
       {isotropic_box(BoxLoad::poke, 0.45), fibrous_box(BoxLoad::poke), isotropic_box(BoxLoad::stretch, 0.45),
        isotropic_box(BoxLoad::stretch, 0.49), fibrous_box(BoxLoad::stretch)})
    boxes.coarsely(question);
  boxes.against_rivals();
  for (const char* note :
       {"coupled extrapolated: with extrapolation = nested, of which poke_error_32 speaks; its "
        "algebra_error is not known.",
        "error: relative L2 over the free nodes against deal.II's quadratic elements, on the reference's "
        "mesh; algebra_error: the "
        "same against the method's own converged answer.",
        "fem_q1: the loosest tolerance found that keeps algebra_error within 1e-3. mib: Answer::bytes, what "
        "the method "
        "counts of its arrays: with the answer for lattice methods, without the mesh for fem_q1.",
        "sweep and relaxed ask for limits and got ones that bind nobody. sweep's weights are the same "
        "whatever the "
        "material, so it runs once a load.",
        "processor_seconds_over_wall below 1: neighbours held the processor. Figures of one thread suffer "
        "alike, "
        "two_threads_speedup and the rivals' few time steps most.",
        "Left out: the largest lattice for fem_q1 and its reference (no time, and 13 GiB and more for Q2); "
        "CHOLMOD beyond "
        "the small lattice (its factor grows with the 4/3rd power of the nodes, its work with the square); "
        "AMG and level "
        "matrices elsewhere (always slower than gmg here); nu 0.45 and fibres on the middle lattice."})
    report.notes.emplace_back(note);
}

} // namespace maille::lab
