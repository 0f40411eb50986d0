#include "bench/bodies/bodies.hpp"

#include "bench/bodies/body_case.hpp"
#include "bench/bodies/body_figures.hpp"
#include "bench/relax/relax.hpp"

#include "maille/deform/solve.hpp"
#include "maille/deform/world/world.hpp"
#include "maille/fem_ref/ranks.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"
#include "maille/scene/world/world_scene.hpp"
#include "verify/verification.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>
#include <string>
#include <thread>
#include <vector>

namespace maille::lab {

namespace {

constexpr double usual = 1e-3; ///< tolerance that checks speak of

/// Products fused with sums, eight independent ones: bound by nothing but arithmetic. @return seconds
double fused_products(int threads, std::int64_t rounds) {
  const auto work = [rounds] {
    volatile double start = 1e-3;
    double sums[8];
    for (double& sum : sums)
      sum = start;
    const double factor = 1 - start;
    for (std::int64_t i = 0; i < rounds; ++i)
      for (double& sum : sums)
        sum = std::fma(sum, factor, start);
    for (const double sum : sums)
      start = sum;
  };
  return median_seconds(
      5, [] {},
      [&] {
        std::vector<std::thread> others;
        for (int i = 1; i < threads; ++i)
          others.emplace_back(work);
        work();
        for (std::thread& other : others)
          other.join();
      });
}

class Bodies {
public:
  Bodies(const BenchOptions& options, BenchReport& report) : options_(options), report_(report) {}

  void answer_all();
  void box_beside_network();
  void contrast();
  void thin_matter();
  void huge_network();
  void finger_on_calf();
  void two_ranks();
  BodyFigures figures;

private:
  void answer(const Body& body);

  BenchOptions options_;
  BenchReport& report_;
};

void Bodies::answer_all() {
  const std::int64_t rounds = options_.quick ? 100'000 : 20'000'000;
  figures.two_threads_of_arithmetic = 2 * fused_products(1, rounds) / fused_products(2, rounds);
  report_.add({{"arithmetic", "a loop of fused products alone"},
               {"two_threads_over_one", figures.two_threads_of_arithmetic}});
  for (const Body& body : bodies(options_, report_))
    answer(body);
}

void Bodies::answer(const Body& body) {
  BodyCase body_case(body, options_.quick, report_);
  AnsweredBody answered;
  answered.unknowns = body_case.unknowns();
  answered.is_box = body_case.is_box();
  answered.materials = static_cast<int>(body.scene.materials.size());
  answered.turns = !body.scene.specimen.fibres.empty();
  body_case.coupled(1e-2);
  answered.coupled = body_case.coupled(usual);
  body_case.coupled(1e-5);
  if (body.name == "gyroid 64")
    figures.iterations_gyroid_1e6 = body_case.coupled(1e-6).iterations;
  answered.own_bytes = body_case.own_bytes_per_unknown(answered.coupled);
  answered.two_threads = body_case.coupled(usual, 2).seconds;
  if (body.has_limits)
    answered.limited = body_case.within_limits(usual);
  if (body.is_against_fem)
    answered.fem = body_case.quickest_fem(usual);
  if (body.name == "both legs")
    figures.next_frame_over_first_legs = body_case.next_frame_over_first(usual);
  figures.bodies.emplace_back(body.name, answered);
}

/// The box that the large network is measured beside, with and without a word on limits.
void Bodies::box_beside_network() {
  const RelaxSizes sizes = RelaxSizes::of(options_);
  const auto seconds_of = [&](Scene scene) {
    scene.relaxation.tolerance = usual;
    return median_answer(options_.quick,
                         [&] { return deform::solve(scene, "coupled", report_.one_thread()); })
        .first.seconds;
  };
  const Scene large = box_scene(isotropic_box(BoxLoad::poke, 0.3), sizes.large);
  figures.ns_per_unknown_of_box = 1e9 * seconds_of(large).total() / (3.0 * std::pow(sizes.large + 1, 3));
  const Scene plain = box_scene(isotropic_box(BoxLoad::poke, 0.3), sizes.middle);
  const Seconds of_plain = seconds_of(plain), of_wide = seconds_of(with_wide_limits(plain));
  figures.default_over_wide = of_plain.total() / of_wide.total();
  report_.add({{"box", nodes_in_words(plain)},
               {"default_s", of_plain.total()},
               {"wide_limits_s", of_wide.total()},
               {"ns_per_unknown_of_large", figures.ns_per_unknown_of_box}});
}

/// A network whose pores are filled with a softer material.
void Bodies::contrast() {
  const BodySizes sizes = BodySizes::of(options_);
  const auto iterations = [&](double filling) {
    Scene scene = gyroid_network(sizes.network, sizes.period, 0.3, filling);
    scene.relaxation.tolerance = usual;
    const Answer answer = deform::solve(scene, "coupled", report_.one_thread());
    report_.add({{"gyroid's filling over its struts", filling},
                 {"iterations", answer.iterations},
                 {"setup_s", answer.seconds.setup},
                 {"solve_s", answer.seconds.solve}});
    return static_cast<double>(answer.iterations);
  };
  const double of_network = iterations(0);
  iterations(1e-2);
  figures.iterations_contrast = iterations(1e-4) / of_network;
}

/// The strip's bend against quadratic elements on half the spacing.
void Bodies::thin_matter() {
  Scene strip = one_cell_strip(options_);
  strip.relaxation.tolerance = 1e-5;
  const Answer answer = deform::solve(strip, "coupled", report_.one_thread());
  const Scene fine = refined(strip);
  const Displacement truth = at_coarse_nodes(
      strip, fine,
      fem_answer(fine, fem_ref::LinearSolver::cholmod, 2, 1e-8, report_.one_thread()).displacement);
  const Displacement q1 =
      fem_answer(strip, fem_ref::LinearSolver::cholmod, 1, 1e-8, report_.one_thread()).displacement;
  figures.one_cell_strip_error = compare(strip, answer.displacement, truth).relative_l2;
  report_.add({{"thin", "strip one cell thick, nu 0.45, bent by a load"},
               {"coupled_error", figures.one_cell_strip_error},
               {"fem_q1_error", compare(strip, q1, truth).relative_l2}});
}

void Bodies::huge_network() {
  const BodySizes sizes = BodySizes::of(options_);
  Scene scene = gyroid_network(sizes.huge_network, sizes.period, 0.25);
  scene.relaxation.tolerance = 1e-2;
  const Answer answer = deform::solve(scene, "coupled", report_.one_thread());
  constexpr double gib = 1 << 30;
  figures.peak_gib_huge = static_cast<double>(answer.bytes) / gib;
  const double unknowns = 3 * static_cast<double>(scene.specimen.n_matter_nodes());
  report_.add({{"huge", "gyroid, a quarter solid"},
               {"cells", sizes.huge_network},
               {"unknowns", unknowns},
               {"setup_s", answer.seconds.setup},
               {"solve_s", answer.seconds.solve},
               {"iterations", answer.iterations},
               {"gib", figures.peak_gib_huge},
               {"status", std::string(to_string(answer.status))},
               {"message", answer.message}});
}

/// Seven muscles of a calf from MRI as they lie, held at both ends, and a round tool of 12 mm beside them.
std::string calf_and_finger() {
  return R"([world]
cells   = [350, 350, 110]
spacing = "1.5 mm"
method  = "coupled"
contact = "surfaces"
[[object]]
name     = "calf"
kind     = "deformable"
shape    = "image"
image    = "$MAILLE_DATA/calf_mri/labels.nii.gz"
labels   = { 13 = "muscle/soleus", 15 = "muscle/soleus", 17 = "muscle/soleus", 19 = "muscle/soleus", 21 = "muscle/soleus", 23 = "muscle/soleus", 25 = "muscle/soleus" }
fibre    = [0, 0, 1]
hold     = [{ where = "z-" }, { where = "z+" }]
position = ["20.3 mm", "20.3 mm", "3.3 mm"]
[[object]]
name     = "finger"
kind     = "rigid"
shape    = "ellipsoid"
surface  = "smooth"
cells    = [8, 8, 8]
spacing  = "1.5 mm"
position = ["250 mm", "240 mm", "70 mm"]
)";
}

void Bodies::finger_on_calf() {
  if (options_.quick || !has_data("calf_mri/labels.nii.gz")) {
    report_.notes.emplace_back("finger_on_calf_fps omitted: MAILLE_DATA names no images, or --quick.");
    return;
  }
  constexpr double metres_a_frame = 1e-3, seconds_a_frame = 1.0 / 20;
  constexpr int frames_there = 16, frames = 6; // it touches in the 17th
  const WorldScene scene = parse_world_scene(calf_and_finger());
  const auto pushed = [](deform::World& world, double by, std::optional<double> budget = std::nullopt) {
    deform::Drive drive;
    drive.object = 1;
    drive.motion.by = {by, 0, 0};
    deform::FrameBudget within;
    within.seconds = budget;
    return world.advance({&drive, 1}, within);
  };
  deform::World hurried(scene), settled(scene);
  pushed(hurried, frames_there * metres_a_frame);
  pushed(settled, frames_there * metres_a_frame);
  double seconds = 0, slowest = 0, of_settled = 0, behind = 0, foreseen = 0, error = 0, largest = 0;
  int n_settled = 0;
  for (int frame = 0; frame < frames; ++frame) {
    const double asked = metres_a_frame + behind; // a hand waits for nothing
    const deform::FrameResult shown = pushed(hurried, asked, seconds_a_frame);
    behind = (1 - shown.drives[0].fraction) * asked;
    seconds += shown.seconds;
    slowest = std::max(slowest, shown.seconds);
    n_settled += shown.status == Status::done;
    const deform::FrameResult truth = pushed(settled, metres_a_frame);
    of_settled += truth.seconds;
    largest = std::max(largest, truth.drives[0].force.norm());
    error = std::max(error, (shown.drives[0].force - truth.drives[0].force).norm());
    foreseen = std::max(foreseen, shown.force_left.value_or(0));
  }
  figures.finger_on_calf_fps = frames / seconds;
  figures.finger_on_calf_error = error / largest;
  report_.add({{"finger", "12 mm, on seven muscles of a calf"},
               {"cells", scene.objects[0].scene.specimen.n_matter_cells()},
               {"frames", frames},
               {"budget_s", seconds_a_frame},
               {"seconds", seconds},
               {"slowest_s", slowest},
               {"settled", n_settled},
               {"behind_m", behind},
               {"force_n", largest},
               {"force_error_n", error},
               {"force_left_n", foreseen},
               {"settled_frames_s", of_settled}});
}

void Bodies::two_ranks() {
  if (const auto found = differences_of_two_ranks(std::filesystem::read_symlink("/proc/self/exe")))
    figures.ranks_2_difference = found->coupled;
  else
    report_.notes.emplace_back("ranks_2_difference omitted: mpirun is not installed, or fails.");
}

} // namespace

double worst_coupled_difference_between_ranks() {
  std::vector<Scene> scenes{gyroid_network(64, 16, 0.3)};
  for (const auto& [image, file] : {std::pair("calf_mri/DTI-tensor.nii.gz", "calf_soleus_dti.toml"),
                                    {"calf_mri/labels.nii.gz", "calf_both_legs.toml"}})
    if (has_data(image))
      scenes.push_back(read_scene(std::filesystem::path(MAILLE_SCENES) / file));
  double worst = 0;
  for (Scene& scene : scenes) {
    scene.limits = {};
    Control together;
    together.communicator = fem_ref::communicator();
    const Answer ours = deform::solve(scene, "coupled", together),
                 whole = deform::solve(scene, "coupled", {});
    if (!is_converged(ours.status) || !is_converged(whole.status))
      return std::numeric_limits<double>::infinity();
    if (fem_ref::ranks().is_first()) // whose answer is whole
      worst = std::max(worst, compare(scene, ours.displacement, whole.displacement).relative_max);
  }
  return worst;
}

void bench_bodies(const BenchOptions& options, BenchReport& report) {
  report.machine = describe_machine();
  const std::size_t bytes = options.quick ? 1 << 20 : 192 << 20;
  report.machine["copy_gb_per_s"] = copy_bandwidth(bytes, options.quick ? 1 : 7, 1);
  report.machine["copy_gb_per_s_two_threads"] = copy_bandwidth(bytes, options.quick ? 1 : 7, 2);
  Bodies all(options, report);
  all.two_ranks(); // before finite elements start MPI in this process, in which mpirun then sees a rank
  all.box_beside_network();
  all.answer_all();
  all.contrast();
  all.thin_matter();
  all.huge_network();
  all.finger_on_calf();
  add_body_checks(all.figures, report);
  for (const char* note :
       {"algebra_error: relative L2 over the free nodes against the method's own tight answer. fem_q1: the "
        "loosest tolerance of powers of ten that keeps it within 1e-3; CHOLMOD where its factor takes less "
        "than 2 minutes and 6 GB; deal.II's geometric multigrid takes boxes alone.",
        "bytes_per_unknown: what the method counts of its arrays at the peak; of boxes without the answer in "
        "float64 (24 bytes a grid point), of other bodies with all there is.",
        "finger_on_calf_fps: a millimetre a frame, for each of which there is 1/20 s; what it leaves is the "
        "next one's. Its error is the largest difference of a force from that of a world whose frames "
        "settle.",
        "ranks_2_difference: a gyroid of 64 cells an axis, the soleus with fibres from DTI, both legs."})
    report.notes.emplace_back(note);
}

} // namespace maille::lab
