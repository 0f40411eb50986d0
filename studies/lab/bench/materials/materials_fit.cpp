#include "bench/materials/materials.hpp"

#include "fit/fit.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/read_scene.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace maille::lab {

namespace {

/// What is done to the free end of a strip of muscle 4 cells across, as part of its length.
struct Deformation {
  const char* name;
  const char* where; ///< with the length for {0} and its quarter, and three quarters, for {1} and {2} [m]
  double x, z;
};

constexpr std::array<Deformation, 3> deformations{
    {{"pulled", "\"x+\"", 1.0 / 16, 0},
     {"bent", "\"x+\"", 0, 1.0 / 16},
     {"poked", "{{ box = [[{1}, 0, 0.008], [{2}, 0.008, 0.008]] }}", 0, -1.0 / 32}}};

Scene strip(const Deformation& deformation, int length, double degrees, double part) {
  const double metres = 0.002 * length;
  const double unit = 0.032 * part; // so that strips of any length are moved alike
  const std::string where = fmt::format(fmt::runtime(deformation.where), metres, 0.008, metres - 0.008);
  return parse_scene(
      fmt::format(
          "units = \"m, rad\"\n[specimen]\nshape = \"box\"\ncells = [{}, 4, 4]\nspacing = \"2 mm\"\n"
          "material = \"muscle/vastus_lateralis\"\nfibre = {{ angle = \"{} deg\", plane = \"xz\" }}\n"
          "[[hold]]\nwhere = \"{}\"\n[[move]]\nwhere = {}\nby = [{}, 0, {}]\n[limits]\nfrom = \"taut\"\n",
          length, degrees, deformation.where[0] == '{' ? "z-" : "x-", where, deformation.x * unit,
          deformation.z * unit),
      fmt::format("{}, {} cells, {:.3g} of the move.toml", deformation.name, length, part));
}

/// A family: what is fitted to, and what the fit never sees.
struct Split {
  const char* name;
  double degrees;
  int other_length; ///< [cells]; those fitted to have 16
  double other_part;
};

constexpr std::array<Split, 4> splits{{{"other size of move, fibre along", 0, 16, 0.5},
                                       {"other length, fibre along", 0, 24, 1},
                                       {"other size of move, fibre at 20 deg", 20, 16, 0.5},
                                       {"other length, fibre at 20 deg", 20, 24, 1}}};

std::vector<FitCase> cases(MaterialsBench& bench, double degrees, int length, double part) {
  std::vector<FitCase> all;
  for (const Deformation& deformation : deformations) {
    Scene scene = strip(deformation, length, degrees, part);
    Displacement reference = bench.displacement(scene, "fem_q2");
    all.push_back({std::move(scene), std::move(reference)});
  }
  return all;
}

/// Sums of squares over unseen scenes.
struct Sums {
  double fitted = 0, taut = 0, floor = 0;
};

void measure(MaterialsBench& bench, const Split& split, Sums& sums) {
  const std::vector<FitCase> seen = cases(bench, split.degrees, 16, 1);
  const std::vector<FitCase> unseen = cases(bench, split.degrees, split.other_length, split.other_part);
  const Fit found = fit(seen, {"limits", bench.is_quick() ? 200 : 20000}, bench.control());
  if (found.status == Status::interrupted)
    throw MaterialsBench::Interrupted{};
  for (const FitCase& one : unseen) {
    const double fitted = fit_error(one, found.materials, "limits", bench.control()).relative_l2;
    const double taut =
        compare(one.scene, bench.displacement(one.scene, "limits"), one.reference).relative_l2;
    const Vec3 lost = unreachable(one);
    const double floor = std::hypot(lost[0], lost[1], lost[2]);
    bench.report().rows.push_back({{"unseen", split.name},
                                   {"scene", one.scene.name},
                                   {"limits_fitted", fitted},
                                   {"limits_taut", taut},
                                   {"no_limits_below", floor},
                                   {"fitted_over_taut", fitted / taut},
                                   {"no_limits_below_over_taut", floor / taut}});
    sums.fitted += fitted * fitted;
    sums.taut += taut * taut;
    sums.floor += floor * floor;
  }
}

} // namespace

void bench_fitted_limits(MaterialsBench& bench, double start, double end) {
  Sums sums;
  double done = 0;
  for (const Split& split : splits) {
    bench.at(start + (end - start) * done++ / static_cast<double>(splits.size()),
             fmt::format("fit: {}", split.name));
    measure(bench, split, sums);
  }
  const double floor = std::sqrt(sums.floor / sums.taut);
  bench.report().checks.push_back(
      {"fit_over_taut_unseen", std::sqrt(sums.fitted / sums.taut), "",
       fmt::format("{:.3g}: no limits at all come below (components do not feel each other)", floor)});
}

} // namespace maille::lab
