/// Sobol indices against closed forms, and those of a study.

#include "studies/study/study_scenes.hpp"
#include "study/plan/sampling.hpp"
#include "study/sensitivity/sensitivity.hpp"
#include "study/study_sensitivity.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>

namespace maille::studies {
namespace {

using Function = std::function<double(const std::vector<double>&)>; // of coordinates in [0, 1)

SampledValues sampled(const UnitPoints& points, const Function& function) {
  SampledValues samples;
  samples.axes.resize(points.front().size());
  for (const std::vector<double>& unit : points) {
    std::vector<double>& point = samples.points.emplace_back();
    for (const double u : unit)
      point.push_back(2 * u - 1);
    samples.values.emplace_back(function(unit));
  }
  return samples;
}

Sensitivity by_pairs(int n, int dimensions, const Function& function) {
  std::vector<std::optional<double>> values;
  for (const std::vector<double>& point : saltelli_points(n, dimensions))
    values.emplace_back(function(point));
  return sobol_by_pairs(dimensions, values);
}

void expect_indices(const Sensitivity& found, const std::vector<double>& first,
                    const std::vector<double>& total, double tolerance) {
  ASSERT_EQ(found.undetermined, "");
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_NEAR(found.first[i].value.value(), first[i], tolerance) << i;
    EXPECT_NEAR(found.total[i].value.value(), total[i], tolerance) << i;
  }
}

void expect_within_intervals(const Sensitivity& found, const std::vector<double>& first,
                             const std::vector<double>& total) {
  constexpr double rounding = 1e-9;
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_LE(found.first[i].low.value(), first[i] + rounding) << i;
    EXPECT_GE(found.first[i].high.value(), first[i] - rounding) << i;
    EXPECT_LE(found.total[i].low.value(), total[i] + rounding) << i;
    EXPECT_GE(found.total[i].high.value(), total[i] - rounding) << i;
  }
}

double ishigami(const std::vector<double>& u) {
  const auto x = [&](std::size_t i) { return std::numbers::pi * (2 * u[i] - 1); };
  return std::sin(x(0)) + 7 * std::pow(std::sin(x(1)), 2) + 0.1 * std::pow(x(2), 4) * std::sin(x(0));
}
// Truth: parts of the variance in closed form (Ishigami and Homma 1990), a = 7, b = 0.1.
const double of_x1 = 0.5 * std::pow(1 + 0.1 * std::pow(std::numbers::pi, 4) / 5, 2), of_x2 = 49.0 / 8,
             of_x1_and_x3 = 0.08 * std::pow(std::numbers::pi, 8) / 225, of_all = of_x1 + of_x2 + of_x1_and_x3;
const std::vector<double> ishigami_first{of_x1 / of_all, of_x2 / of_all, 0},
    ishigami_total{(of_x1 + of_x1_and_x3) / of_all, of_x2 / of_all, of_x1_and_x3 / of_all};

TEST(SobolIndicesAnalytic, OfIshigamisFunction) {
  expect_indices(sobol_by_chaos(sampled(latin_hypercube(512, 3, 1), ishigami)), ishigami_first,
                 ishigami_total, 1e-5);
  expect_indices(sobol_by_chaos(sampled(sobol_points(256, 3), ishigami)), ishigami_first, ishigami_total,
                 1e-4);
  expect_indices(by_pairs(2048, 3, ishigami), ishigami_first, ishigami_total, 0.02);
  expect_within_intervals(by_pairs(2048, 3, ishigami), ishigami_first, ishigami_total);
}

/// Sobol's G function, kinked in the middle of every axis.
struct Kinked {
  std::vector<double> a{0, 0.5, 3, 9, 99, 99};
  double operator()(const std::vector<double>& u) const {
    double product = 1;
    for (std::size_t i = 0; i < a.size(); ++i)
      product *= (std::abs(4 * u[i] - 2) + a[i]) / (1 + a[i]);
    return product;
  }
  double part(std::size_t i) const { return 1 / (3 * std::pow(1 + a[i], 2)); }
  double all() const {
    double product = 1;
    for (std::size_t i = 0; i < a.size(); ++i)
      product *= 1 + part(i);
    return product - 1;
  }
  std::vector<double> first() const {
    std::vector<double> list;
    for (std::size_t i = 0; i < a.size(); ++i)
      list.push_back(part(i) / all());
    return list;
  }
  std::vector<double> total() const {
    std::vector<double> list;
    for (std::size_t i = 0; i < a.size(); ++i)
      list.push_back(part(i) / (1 + part(i)) * (1 + all()) / all());
    return list;
  }
};

TEST(SobolIndicesAnalytic, OfSobolsGFunction) {
  const Kinked kinked;
  for (const int n : {64, 128, 512}) {
    const Sensitivity found = sobol_by_chaos(sampled(latin_hypercube(n, 6, 2), kinked));
    if (found.undetermined.empty()) // few samples may say that they do not tell
      expect_within_intervals(found, kinked.first(), kinked.total());
    EXPECT_TRUE(n < 512 || found.undetermined.empty());
  }
  const Sensitivity by_512 = sobol_by_chaos(sampled(sobol_points(512, 6), kinked));
  expect_indices(by_512, kinked.first(), kinked.total(), 0.02);
  EXPECT_GT(by_512.unexplained, 1e-3) << "polynomials do not follow kinks, and say so";
  const Sensitivity pairs = by_pairs(1024, 6, kinked);
  expect_indices(pairs, kinked.first(), kinked.total(), 0.02);
}

TEST(SobolIndicesAnalytic, SumsHaveNoInteractionsAndTheDeadHaveNone) {
  const Function sum = [](const std::vector<double>& u) { return 5 + u[0] - 2 * u[1] + 3 * u[3]; };
  const std::vector<double> shares{1.0 / 14, 4.0 / 14, 0, 9.0 / 14};
  expect_indices(sobol_by_chaos(sampled(latin_hypercube(20, 4, 3), sum)), shares, shares, 1e-10);
  const Sensitivity pairs = by_pairs(256, 4, sum);
  EXPECT_EQ(pairs.first[2].value, 0.0);
  EXPECT_EQ(pairs.total[2].value, 0.0);
  expect_indices(pairs, shares, shares, 0.02);
}

TEST(SobolIndicesAnalytic, ColumnsMayChangePlaces) {
  const UnitPoints points = latin_hypercube(128, 3, 4);
  UnitPoints turned = points;
  for (std::vector<double>& point : turned)
    std::rotate(point.begin(), point.begin() + 1, point.end());
  const Function of_turned = [](const std::vector<double>& u) { return ishigami({u[2], u[0], u[1]}); };
  const Sensitivity one = sobol_by_chaos(sampled(points, ishigami)),
                    other = sobol_by_chaos(sampled(turned, of_turned));
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(one.first[(i + 1) % 3].value.value(), other.first[i].value.value(), 1e-9);
    EXPECT_NEAR(one.total[(i + 1) % 3].value.value(), other.total[i].value.value(), 1e-9);
  }
}

TEST(SobolIndicesAnalytic, SamplesWithoutAValueAreLeftOutAndCounted) {
  SampledValues samples = sampled(latin_hypercube(400, 3, 5), ishigami);
  for (std::size_t i = 0; i < samples.values.size(); i += 4)
    samples.values[i] = i % 8 == 0 ? std::nullopt : std::optional<double>(NAN);
  const Sensitivity found = sobol_by_chaos(samples);
  EXPECT_EQ(found.n_left_out, 100);
  EXPECT_EQ(found.n_used, 300);
  expect_indices(found, ishigami_first, ishigami_total, 1e-4);

  std::vector<std::optional<double>> of_pairs;
  for (const std::vector<double>& point : saltelli_points(1024, 3))
    of_pairs.emplace_back(ishigami(point));
  of_pairs[7].reset(); // of the second block
  const Sensitivity by_blocks = sobol_by_pairs(3, of_pairs);
  EXPECT_EQ(by_blocks.n_left_out, 5) << "a block is of use as a whole";
  expect_indices(by_blocks, ishigami_first, ishigami_total, 0.05);
}

TEST(SobolIndicesAnalytic, OfAGridThoseOfItsTable) {
  // Truth: by hand. f = i j over i in {0, 1}, j in {0, 1, 2}: mean 1/2, variance 7/12; over j the means of i
  // are 0 and 1 (1/4), over i those of j 0, 1/2 and 1 (1/6).
  const Sensitivity found = sobol_by_grid({2, 3}, {0.0, 0.0, 0.0, 0.0, 1.0, 2.0});
  expect_indices(found, {3.0 / 7, 2.0 / 7}, {5.0 / 7, 4.0 / 7}, 1e-14);
  EXPECT_EQ(found.first[0].low, found.first[0].high);
  EXPECT_NE(sobol_by_grid({2, 3}, {0.0, 0.0, 0.0, 0.0, 1.0, std::nullopt}).undetermined, "");
  // Polynomials on those levels, each several times, tell the same.
  SampledValues samples;
  samples.axes = {{{-1, 1}}, {{-1, 0, 1}}};
  for (int copy = 0; copy < 3; ++copy)
    for (const int i : {0, 1})
      for (const int j : {0, 1, 2}) {
        samples.points.push_back({2.0 * i - 1, j - 1.0});
        samples.values.emplace_back(i * j);
      }
  expect_indices(sobol_by_chaos(samples), {3.0 / 7, 2.0 / 7}, {5.0 / 7, 4.0 / 7}, 1e-10);
}

TEST(SobolIndicesContract, WhatSamplesDoNotTellIsSaid) {
  const Function constant = [](const std::vector<double>&) { return 3.0; };
  EXPECT_EQ(sobol_by_chaos(sampled(latin_hypercube(50, 2, 1), constant)).undetermined,
            "the value is the same in all samples");
  EXPECT_EQ(by_pairs(16, 2, constant).undetermined, "the value is the same in all samples");
  EXPECT_EQ(sobol_by_chaos(sampled(latin_hypercube(9, 3, 1), ishigami)).undetermined,
            "9 samples with a value, at least 10 are needed");
  std::mt19937_64 lot(7);
  const Function noise = [&](const std::vector<double>&) { return static_cast<double>(lot() >> 12U); };
  const Sensitivity of_noise = sobol_by_chaos(sampled(latin_hypercube(100, 3, 1), noise));
  EXPECT_TRUE(test::has(of_noise.undetermined, "more samples are needed"));
  EXPECT_FALSE(of_noise.first[0].value.has_value());
  EXPECT_NE(by_pairs(4, 3, ishigami).undetermined, "");
}

TEST(StudyPlanAnalytic, SaltellisBlocksMixTwoPoints) {
  const UnitPoints points = saltelli_points(8, 3);
  ASSERT_EQ(points.size(), 8u * 5);
  for (std::size_t first = 0; first < points.size(); first += 5)
    for (std::size_t axis = 0; axis < 3; ++axis)
      for (std::size_t d = 0; d < 3; ++d)
        EXPECT_EQ(points[first + 2 + axis][d], points[first + (d == axis ? 1 : 0)][d]);
}

/// A study of a stiffness and a named material's place, and rows of it that no method has made.
struct OfRows {
  explicit OfRows(const std::string& plan) {
    folder.write("strip.toml", test::small_strip);
    study = parse_study(test::small_head + plan, folder / "study.toml");
    for (const StudyCase& one : cases(study))
      for (const std::string& method : study.row_methods()) {
        StudyRow& row = rows.emplace_back();
        row.scene = "strip";
        row.number = one.number;
        row.method = method;
        for (std::size_t p = 0; p < study.parameters.size(); ++p)
          row.parameters.emplace_back(study.parameters[p].column(), one.values[p].shown);
      }
  }
  const StudySensitivity& of(const std::vector<StudySensitivity>& all, const std::string& method) const {
    for (const StudySensitivity& one : all)
      if (one.method == method && one.response == "force")
        return one;
    throw std::out_of_range(method);
  }
  test::StudyFolder folder;
  StudyFile study;
  std::vector<StudyRow> rows;
};

const std::string over_decades =
    test::parameter("specimen.material.E_fibre", "log_range = [\"1 kPa\", \"100 kPa\"]");

// Truth: the logarithm of E is uniform: f = log E + angle / 45 deg, log10 E over 2 decades, has shares 4 : 1.
TEST(StudySensitivityAnalytic, RangesAreTakenAsTheyAreDrawn) {
  for (const char* plan : {"latin_hypercube", "sobol", "saltelli"}) {
    OfRows made(std::string("combine = \"") + plan + "\"\nsamples = 64\n" + over_decades +
                test::parameter("specimen.fibre.angle", "range = [\"0 deg\", \"45 deg\"]"));
    for (StudyRow& row : made.rows)
      if (row.method == "relaxed")
        row.force = std::log10(std::get<double>(row.parameters[0].second)) +
                    std::get<double>(row.parameters[1].second) / 45;
    made.rows[1].force.reset();
    const auto all = sensitivities(made.study, made.rows);
    ASSERT_EQ(all.size(), 1u) << "limits and fem_q1 have none";
    const Sensitivity& found = made.of(all, "relaxed").found;
    EXPECT_EQ(found.n_left_out, std::string(plan) == "saltelli" ? 4 : 1);
    const double tolerance = std::string(plan) == "saltelli" ? 0.1 : 1e-8;
    expect_indices(found, {0.8, 0.2}, {0.8, 0.2}, tolerance);
    EXPECT_EQ(all.front().label, "force [N]");
    EXPECT_EQ(all.front().parameters[1], "specimen.fibre.angle [deg]");
  }
}

TEST(StudySensitivityAnalytic, ListsAndTextsCountEveryValueAlike) {
  OfRows made(test::parameter("specimen.fibre.plane", "values = [\"xy\", \"yx\"]") +
              test::parameter("move.0.by.0", "values = [\"1 mm\", \"2 mm\", \"3 mm\"]"));
  for (StudyRow& row : made.rows)
    row.force = (std::get<std::string>(row.parameters[0].second) == "yx" ? 1 : 0) *
                (std::get<double>(row.parameters[1].second) - 1);
  const auto all = sensitivities(made.study, made.rows);
  expect_indices(made.of(all, "limits").found, {3.0 / 7, 2.0 / 7}, {5.0 / 7, 4.0 / 7}, 1e-12);
  const nlohmann::ordered_json one = json(all).front();
  EXPECT_EQ(one["response"], "force");
  EXPECT_TRUE(one["undetermined"] == "");
  EXPECT_NEAR(one["parameters"][0]["first"].get<double>(), 3.0 / 7, 1e-12);
  EXPECT_TRUE(test::has(in_words(all, "force"), "Sobol indices of force [N]"));
  EXPECT_EQ(in_words(all, "strain_energy"), "");
}

TEST(StudySensitivityContract, ZippedParametersAreNotToldApart) {
  OfRows made("combine = \"zip\"\n" +
              test::parameter("specimen.fibre.angle", "values = [\"0 deg\", \"9 deg\"]") +
              test::parameter("move.0.by.0", "values = [\"1 mm\", \"2 mm\"]"));
  for (StudyRow& row : made.rows)
    row.force = row.number;
  const auto all = sensitivities(made.study, made.rows);
  EXPECT_TRUE(test::has(all.front().found.undetermined, "zipped"));
  EXPECT_TRUE(json(all).front()["parameters"][0]["first"].is_null());
}

} // namespace
} // namespace maille::studies
