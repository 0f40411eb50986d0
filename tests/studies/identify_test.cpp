/// Constants from measured numbers: the search by itself on models in closed form, and the command.
#include "identify/identify.hpp"

#include "studies/commands/run_command.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>

namespace maille::studies {
namespace {

using test::maille_command;
using test::Outcome;

std::vector<Observation> observed(const std::vector<double>& values, std::optional<double> sigma = {}) {
  std::vector<Observation> all;
  for (const double value : values)
    all.push_back({"y", value, sigma, 0});
  return all;
}

/// y_i = a exp(-b i), i = 0 ... n - 1.
Model decay(int n) {
  return [n](const std::vector<double>& p) {
    std::vector<double> y;
    for (int i = 0; i < n; ++i)
      y.push_back(p[0] * std::exp(-p[1] * i));
    return std::optional(y);
  };
}

// Truth: the values that the data were made with.
TEST(IdentifyAnalytic, FindsWhatExactDataWereMadeWith) {
  for (const double start : {0.01, 0.3, 1.0, 40.0}) {
    const Model bar = [](const std::vector<double>& p) { return std::optional(std::vector{0.02 * p[0]}); };
    const Identification one = identify({{"E", start * 12e3}}, observed({0.02 * 12e3}), bar);
    EXPECT_EQ(one.status, IdentifyStatus::done) << one.message;
    EXPECT_NEAR(one.unknowns[0].value, 12e3, 1e-3 * 12e3);
    EXPECT_LE(one.solves, 36); // 12 a start
    EXPECT_FALSE(one.unknowns[0].interval) << "one datum and no sigma tell nothing of its error";
  }
  // A pull towards -x, far from a line in its stiffness.
  const Model cord = [](const std::vector<double>& p) {
    return std::optional(std::vector{-std::pow(p[0], 0.1)});
  };
  const Identification negative = identify({{"E", 12}}, observed({-std::pow(500, 0.1)}, 0.001), cord);
  EXPECT_EQ(negative.status, IdentifyStatus::done) << negative.message;
  EXPECT_NEAR(negative.unknowns[0].value, 500, 0.5);
  const auto data = *decay(6)({3, 0.4});
  const Identification two = identify({{"a", 1}, {"b", 1.5}}, observed(data), decay(6));
  EXPECT_EQ(two.status, IdentifyStatus::done) << two.message;
  EXPECT_NEAR(two.unknowns[0].value, 3, 3e-3);
  EXPECT_NEAR(two.unknowns[1].value, 0.4, 4e-4);
  EXPECT_LE(two.solves, 72);
  for (std::size_t i = 0; i < data.size(); ++i)
    EXPECT_NEAR(two.computed[i], data[i], 1e-3 * data[i]);
}

// Truth: an interval of 95 % has the true value in it 95 times of 100, in 600 draws to 3 standard deviations.
TEST(IdentifyAnalytic, IntervalsHoldTheTruthAsOftenAsTheySay) {
  std::mt19937_64 generator(7);
  std::normal_distribution<double> noise;
  const auto exact = *decay(7)({3, 0.4});
  for (const bool is_known : {true, false}) {
    std::array<int, 2> held{};
    constexpr int draws = 600;
    for (int draw = 0; draw < draws; ++draw) {
      auto data = exact;
      const double sigma = 0.02;
      for (double& value : data)
        value += sigma * (is_known ? 1 : value) * noise(generator);
      const Identification found = identify(
          {{"a", 2}, {"b", 0.5}}, observed(data, is_known ? std::optional(sigma) : std::nullopt), decay(7));
      ASSERT_EQ(found.status, IdentifyStatus::done) << found.message;
      const std::array<double, 2> truth{3, 0.4};
      for (std::size_t j = 0; j < 2; ++j) {
        ASSERT_TRUE(found.unknowns[j].interval);
        held[j] +=
            found.unknowns[j].interval->first <= truth[j] && truth[j] <= found.unknowns[j].interval->second;
      }
    }
    for (const int count : held) {
      EXPECT_GT(count, 0.923 * draws) << is_known;
      EXPECT_LT(count, 0.977 * draws) << is_known;
    }
  }
}

// Truth: by construction: a product tells nothing of its factors, and what is not in a model nothing at all.
TEST(IdentifyAnalytic, SaysWhatTheDataLeaveOpen) {
  const Model product = [](const std::vector<double>& p) {
    return std::optional(std::vector{p[0] * p[1], 2 * p[0] * p[1], 5 * p[0] * p[1]});
  };
  const Identification together =
      identify({{"width", 2}, {"height", 7}}, observed({6, 12, 30}, 0.01), product);
  EXPECT_EQ(together.status, IdentifyStatus::undetermined);
  EXPECT_TRUE(test::has(together.message, "width and height one by one"));
  EXPECT_FALSE(together.unknowns[0].is_determined || together.unknowns[1].is_determined);
  EXPECT_NEAR(together.unknowns[0].value * together.unknowns[1].value, 6, 1e-3);
  const Model first = [](const std::vector<double>& p) {
    return std::optional(std::vector{p[0], 3 * p[0] * std::pow(p[1], 1e-7)});
  };
  const Identification unheard = identify({{"E", 2}, {"nu", 0.3}}, observed({4, 12}, 0.01), first);
  EXPECT_EQ(unheard.status, IdentifyStatus::undetermined);
  EXPECT_TRUE(test::has(unheard.message, "determine nu: a change of it"));
  EXPECT_TRUE(unheard.unknowns[0].is_determined);
  EXPECT_NEAR(unheard.unknowns[0].value, 4, 1e-3);
}

// Truth: by construction: x and 1 / x fit alike, and a plateau hides an unknown that slopes at its rim
// still tell.
TEST(IdentifyAnalytic, SaysWhatFitsAsWellElsewhere) {
  const Model even = [](const std::vector<double>& p) {
    const double x = std::log(p[0]);
    return std::optional(std::vector{x * x, 3 * x * x, 2 * p[1]});
  };
  const Identification both = identify({{"E", 2}, {"G", 5}}, observed({0.25, 0.75, 8}, 0.01), even);
  EXPECT_EQ(both.status, IdentifyStatus::undetermined);
  EXPECT_TRUE(test::has(both.message, "E: "));
  EXPECT_FALSE(both.unknowns[0].is_determined);
  EXPECT_TRUE(both.unknowns[1].is_determined);
  const Model plateau = [](const std::vector<double>& p) {
    return std::optional(std::vector{p[0], p[0] / (1 + std::pow(p[1], -2))});
  };
  const Identification hidden = identify({{"E", 1}, {"E_cross", 3}}, observed({1, 0.97}, 0.02), plateau);
  EXPECT_EQ(hidden.status, IdentifyStatus::undetermined) << hidden.unknowns[1].value;
  EXPECT_FALSE(hidden.unknowns[1].is_determined);
}

TEST(IdentifyContract, EndsWhereTheModelDoes) {
  const Model none = [](const std::vector<double>&) { return std::optional<std::vector<double>>(); };
  const Identification failed = identify({{"E", 1}}, observed({1, 2}), none);
  EXPECT_EQ(failed.status, IdentifyStatus::failed);
  EXPECT_FALSE(failed.unknowns[0].is_determined);
  Control control;
  control.stop_requested = [] { return true; };
  EXPECT_EQ(identify({{"a", 1}, {"b", 1}}, observed({1, 2, 3}), decay(3), {}, control).status,
            IdentifyStatus::interrupted);
  EXPECT_EQ(identify({{"a", 1}, {"b", 9}}, observed(*decay(5)({300, 0.1})), decay(5), {1e-4, 4}).status,
            IdentifyStatus::budget_reached);
}

TEST(ObservationsContract, EveryFaultAtOnce) {
  const std::vector<std::pair<std::string, std::string>> units{{"pull", "N"}, {"tip", "m"}, {"work", "J"}};
  const auto read = [&](const std::string& text) { return read_observations(text, "data.csv", units); };
  const auto good =
      read("# a comment\nmeasure, value, sigma\npull, 20 N, 0.5 N\ntip, 2 mm, 0.1 mm\nwork,3,1\n");
  ASSERT_EQ(good.size(), 3u);
  EXPECT_EQ(good[0].value, 20);
  EXPECT_EQ(good[1].value, 2e-3);
  EXPECT_EQ(*good[1].sigma, 1e-4);
  EXPECT_EQ(good[2].line, 5);
  const auto faults = test::faults_found_by(
      [&] { read("measure,value,sigma\npul,1,1\npull,2 mm,1\ntip,1,-3\ntip,1\nwork,nan,1\na,b,c,d\n"); });
  ASSERT_EQ(faults.size(), 7u) << InputError(faults).what();
  const std::array<int, 7> lines{2, 3, 4, 5, 5, 6, 7};
  for (std::size_t i = 0; i < 7; ++i)
    EXPECT_EQ(faults[i].line, lines[i]) << to_string(faults[i]);
  for (const char* bad : {"", "value,measure\n", "measure,value\n", "measure\npull\n"})
    EXPECT_EQ(test::faults_found_by([&] { read(bad); }).size(), 1u) << bad;
}

const std::string block = R"(units = "mm"
[specimen]
shape = "box"
cells = [8, 4, 4]
spacing = 1
material = { E_fibre = "30 kPa", E_cross = "12 kPa", G_fibre = "5 kPa", nu_fibre = 0.3, nu_cross = 0.4 }
[[hold]]
where = "x-"
[[move]]
where = "x+"
by = [0.4, 0, 0.4]
[[measure]]
name = "pull"
force = "move[1]"
[[measure]]
name = "side"
displacement = { at = [4, 4, 2] }
component = "y"
)";

/// The measures of an answer as observations. @param scene  the file that is run
std::string observations_of(const std::string& scene) {
  std::string csv = "measure,value\n";
  const auto answer = test::json_of("run " + scene + " --json");
  for (const auto& measure : answer["results"][0]["measures"])
    if (measure["name"] == "pull")
      csv += fmt::format("pull_x,{:.17g} N\npull_z,{:.17g}\n", measure["vector"][0].get<double>(),
                         measure["vector"][2].get<double>());
    else
      csv += fmt::format("side,{:.17g}\n", measure["value"].get<double>());
  return csv;
}

// Truth: the constants that the numbers were computed with.
TEST(IdentifyCommandAnalytic, FindsTheConstantsOfItsOwnAnswer) {
  const test::TemporaryFolder folder;
  const std::string truth = folder.write("truth.toml", block).string(),
                    data = folder.write("data.csv", observations_of(truth)).string();
  std::string text = block;
  text.replace(text.find("30 kPa"), 6, "90 kPa");
  text.replace(text.find("\"5 kPa"), 6, "\"2 kPa");
  const std::string start = folder.write("start.toml", text).string();
  const auto json =
      test::json_of(fmt::format("fit {} --measured {} --unknown "
                                "specimen.material.E_fibre,specimen.material.G_fibre --json --out {}",
                                start, data, (folder / "fitted.toml").string()));
  EXPECT_EQ(json["status"], "done");
  EXPECT_LE(json["solves"].get<int>(), 72);
  EXPECT_NEAR(json["unknowns"][0]["value"].get<double>(), 30, 0.3);
  EXPECT_NEAR(json["unknowns"][1]["value"].get<double>(), 5, 0.05);
  for (const auto& row : json["observations"])
    EXPECT_NEAR(row["computed"].get<double>(), row["measured"].get<double>(),
                1e-3 * std::abs(row["measured"].get<double>()));
  test::done("run " + (folder / "fitted.toml").string() + " --json");
}

// Truth: the constants that the numbers were computed with; the search begins with those of the library.
TEST(IdentifyCommandAnalytic, FindsConstantsByTheNameOfTheirMaterial) {
  const test::TemporaryFolder folder;
  const std::string from =
      R"({ E_fibre = "30 kPa", E_cross = "12 kPa", G_fibre = "5 kPa", nu_fibre = 0.3, nu_cross = 0.4 })";
  std::string truth = block, start = block;
  truth.replace(
      truth.find(from), from.size(),
      R"({ E_fibre = "13 kPa", E_cross = "3.68 kPa", G_fibre = "2 kPa", nu_fibre = 0.4566, nu_cross = 0.7113 })");
  start.replace(start.find(from), from.size(), "\"muscle/soleus\"");
  const std::string seen = observations_of(folder.write("truth.toml", truth).string()),
                    scene = folder.write("start.toml", start).string(),
                    data = folder.write("data.csv", seen.substr(0, seen.find("side"))).string();
  const std::string command = "fit " + scene + " --measured " + data;
  const auto unknowns =
      test::json_of(command + " --unknown \"E_fibre, G_fibre of muscle/soleus\" --json --out " +
                    (folder / "fitted.toml").string())["unknowns"];
  EXPECT_EQ(unknowns[0]["unknown"], "E_fibre of muscle/soleus");
  EXPECT_NEAR(unknowns[0]["value"].get<double>(), 13e3, 130);
  EXPECT_NEAR(unknowns[1]["value"].get<double>(), 2e3, 20);
  test::done("check " + (folder / "fitted.toml").string());
  test::expect_refused({
      {command + " --unknown \"E_fibre of muscle/masseter\"", "the name of a material in [specimen]"},
      {command + " --unknown \"youngs_modulus of muscle/soleus\"", "one of E_fibre, E_cross, G_fibre"},
      {command + " --unknown \"stiffness of muscle/soleus\"", "a constant that stands in its table"},
  });
}

TEST(IdentifyCommandContract, SaysWhatIsWrongAndWhatIsOpen) {
  const test::TemporaryFolder folder;
  const std::string scene = folder.write("scene.toml", block).string();
  const std::string data =
      folder.write("data.csv", "measure,value,sigma\npull_x,0.02,0.001\nside,-0.05 mm,0.01 mm\n").string();
  const auto identified = [&](const std::string& with, const std::string& unknown) {
    return "fit " + scene + " --measured " + with + " --unknown " + unknown;
  };
  const std::string E = "specimen.material.E_fibre";
  test::expect_refused({
      {identified(data, "specimen.material.E"), "leads to"},
      {identified(data, "specimen.shape"), "expected a number > 0"},
      {identified(data, E + " --method limits"), "knows forces"},
      {identified(data, E + ",specimen.material.E_cross,specimen.material.G_fibre"), "at least as many"},
      {identified(folder.write("odd.csv", "measure,value\npush,1\n").string(), E),
       "odd.csv:2: measure: expected a measure of the scene: pull, pull_x"},
      {identified((folder / "nowhere.csv").string(), E), "nowhere.csv"},
      {identified(folder.write("zero.csv", "measure,value\npull_x,0\n").string(), E), "zeros alone"},
  });
  // Stiffness alone changes no displacement where all that is done to a body is to move it.
  const std::string side = folder.write("side.csv", "measure,value,sigma\nside,-0.05 mm,0.01 mm\n").string();
  std::string isotropic = block;
  const auto from = isotropic.find("material ="), to = isotropic.find("[[hold]]");
  isotropic.replace(from, to - from, "material = { youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n");
  const Outcome open = maille_command("fit " + folder.write("iso.toml", isotropic).string() + " --measured " +
                                      side + " --unknown specimen.material.youngs_modulus");
  EXPECT_EQ(open.code, 1) << open.err;
  EXPECT_TRUE(test::has(open.out, "do not determine specimen.material.youngs_modulus"));
}

} // namespace
} // namespace maille::studies
