#include "stability/extremes.hpp"
#include "stability/questions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace maille::lab {

namespace {

constexpr double strain = 0.01;
constexpr int n = 8;
constexpr double length = n * 1e-3;
constexpr Vec3 h{1e-3, 1e-3, 1e-3};

/// Stiff and soft halves, pulled; without contraction the pull is that of two springs.
void add_series(std::vector<Extreme>& list, double contrast) {
  const auto ask = [=] {
    Scene scene = Question{.cells = "[8, 3, 3]",
                           .material = "{ youngs_modulus = 10000, poisson_ratio = 0 }",
                           .conditions = pulled(3, 0, strain * length)}
                      .scene();
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].elasticity = ElasticConstants::isotropic(contrast * 10e3, 0);
    for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell)
      scene.specimen.material_id.push_back(scene.specimen.grid.cell_at(cell)[0] < n / 2 ? 0 : 1);
    return scene;
  };
  std::vector<double> stiffness(n, 1);
  std::fill(stiffness.begin() + n / 2, stiffness.end(), contrast);
  list.push_back({.extreme = "stiffness contrast",
                  .setting = fmt::format("{:g}, halves in series, pulled", contrast),
                  .scene = ask,
                  .truth = in_series(stiffness, strain * length),
                  .is_normal = contrast == 1});
}

/// Cubes of two cells a side, soft and stiff in turn.
void add_checker(std::vector<Extreme>& list, double contrast) {
  const auto ask = [=] {
    Scene scene = Question{.conditions = poked(h, 0.5e-3)}.scene();
    scene.materials.push_back(scene.materials[0]);
    scene.materials[1].elasticity = ElasticConstants::isotropic(contrast * 10e3, 0.3);
    for (std::int64_t cell = 0; cell < scene.specimen.grid.n_cells(); ++cell) {
      const Index3 at = scene.specimen.grid.cell_at(cell);
      scene.specimen.material_id.push_back(
          static_cast<std::uint8_t>((at[0] / 2 + at[1] / 2 + at[2] / 2) % 2));
    }
    return scene;
  };
  list.push_back({.extreme = "stiffness contrast, checkered",
                  .setting = fmt::format("{:g}, poked", contrast),
                  .scene = ask,
                  .is_normal = contrast == 1});
}

std::string fibrous(double ratio) {
  return fmt::format("{{ E_fibre = {}, E_cross = 10000, G_fibre = 4000, nu_fibre = 0.3, nu_cross = 0.3 }}",
                     ratio * 10e3);
}

void add_anisotropy(std::vector<Extreme>& list, double ratio) {
  const auto pull = [&](const char* fibre, const char* how, const Vec3& strains) {
    list.push_back({.extreme = fmt::format("anisotropy, pulled {} the fibre", how),
                    .setting = fmt::format("E_fibre / E_cross = {:g}", ratio),
                    .scene =
                        [=] {
                          return Question{.material = fibrous(ratio),
                                          .fibre = fibre,
                                          .conditions = pulled(3, 0, strain * length)}
                              .scene();
                        },
                    .truth = uniform_strain(strains, 0),
                    .is_normal = ratio == 1});
  };
  pull("[1, 0, 0]", "along", {strain, -0.3 * strain, -0.3 * strain});
  pull("[0, 0, 1]", "across", {strain, -0.3 * strain, -0.3 / ratio * strain});
  list.push_back({.extreme = "anisotropy, clamped ends aslant to the fibre",
                  .setting = fmt::format("E_fibre / E_cross = {:g}", ratio),
                  .scene =
                      [=] {
                        return Question{.material = fibrous(ratio),
                                        .fibre = "[0.8, 0.36, 0.48]",
                                        .conditions = clamped("[0.0002, 0, 0.0001]")}
                            .scene();
                      },
                  .is_normal = ratio == 1});
}

void add_poisson(std::vector<Extreme>& list, double nu) {
  const std::string matter = fmt::format("{{ youngs_modulus = 10000, poisson_ratio = {} }}", nu);
  list.push_back(
      {.extreme = "Poisson ratio, pulled",
       .setting = fmt::format("{}", nu),
       .scene =
           [=] { return Question{.material = matter, .conditions = pulled(3, 0, strain * length)}.scene(); },
       .truth = uniform_strain({strain, -nu * strain, -nu * strain}, 0),
       .is_normal = nu == 0.3});
  list.push_back(
      {.extreme = "Poisson ratio, poked",
       .setting = fmt::format("{}", nu),
       .scene = [=] { return Question{.material = matter, .conditions = poked(h, 0.5e-3)}.scene(); },
       .is_normal = nu == 0.3});
}

/// Keeps those of one extreme together, in the order of its settings.
void move_behind(std::vector<Extreme>& from, std::vector<Extreme>& to) {
  std::stable_sort(from.begin(), from.end(),
                   [](const Extreme& a, const Extreme& b) { return a.extreme < b.extreme; });
  std::move(from.begin(), from.end(), std::back_inserter(to));
}

} // namespace

void add_extremes_of_matter(std::vector<Extreme>& list) {
  std::vector<Extreme> mine;
  for (const double contrast : {1.0, 1e2, 1e4, 1e6, 1e8}) {
    add_series(mine, contrast);
    add_checker(mine, contrast);
  }
  for (const double ratio : {1.0, 1e2, 1e4, 1e6})
    add_anisotropy(mine, ratio);
  for (const double nu : {0.3, 0.0, 0.49, 0.499, 0.4999, 0.49999, -0.5, -0.9, -0.99})
    add_poisson(mine, nu);
  move_behind(mine, list);
}

} // namespace maille::lab
