// Quantiles, tables and the choice itself on numbers made up; probes on small scenes.

#include "choose/choose.hpp"
#include "compare/methods.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>

namespace maille::studies {
namespace {

// Analytic: of n = 19 numbers the ceil(20 * 0.95) = 19th, of 99 the 95th; too few say nothing.
TEST(QuantilesAnalytic, AreTheConformalRanks) {
  std::vector<double> values;
  for (int i = 1; i <= 99; ++i)
    values.push_back(i);
  EXPECT_EQ(upper_quantile(values, 0.95), 95);
  EXPECT_EQ(lower_quantile(values, 0.95), 5);
  EXPECT_EQ(upper_quantile(values, 0.5), 50);
  const std::span<const double> nineteen(values.data(), 19), eighteen(values.data(), 18);
  EXPECT_EQ(upper_quantile(nineteen, 0.95), 19);
  EXPECT_EQ(lower_quantile(nineteen, 0.95), 1);
  EXPECT_EQ(upper_quantile(eighteen, 0.95), std::numeric_limits<double>::infinity());
  EXPECT_EQ(lower_quantile(eighteen, 0.95), 0);
}

const Way way{"coupled", -1, 1e-2};

// Analytic: ratios of measured to predicted are 1/2, 1 and 2.
TEST(CalibrationAnalytic, MultipliesRawValuesByRatios) {
  std::vector<StoredRow> rows;
  for (const double ratio : {2.0, 0.5, 1.0})
    rows.push_back({way, 0.1 * ratio, 0.1, 3 * ratio, 3});
  const Calibration calibration(rows);
  ASSERT_EQ(calibration.ways(), std::vector<Way>{way});
  const Expected error = calibration.error(way, 0.04, 0.75), seconds = calibration.seconds(way, 8, 0.75);
  EXPECT_DOUBLE_EQ(error.median, 0.04);
  EXPECT_DOUBLE_EQ(error.low, 0.02);
  EXPECT_DOUBLE_EQ(error.high, 0.08);
  EXPECT_DOUBLE_EQ(seconds.high, 16);
  EXPECT_TRUE(std::isinf(calibration.error(way, 0.04, 0.95).high)) << "three rows cannot say";
  EXPECT_THROW((void)calibration.error({"coupled", 0, 1e-2}, 1, 0.5), std::logic_error);
}

// Analytic: of a scene that stands there twice one row counts; another prediction is another scene of that
// name.
TEST(CalibrationAnalytic, AScenesRowsCountOnce) {
  std::vector<StoredRow> rows;
  for (int i = 0; i < 18; ++i)
    rows.push_back({way, 0.1 + 0.01 * i, 0.1, 3, 3, "scene " + std::to_string(i)});
  const auto high = [&] { return Calibration(rows).error(way, 0.1, 0.95).high; };
  EXPECT_EQ(Calibration(rows).n_scenes(), 18u);
  EXPECT_TRUE(std::isinf(high()));
  const std::vector<StoredRow> again = rows;
  for (StoredRow row : again) { // measured again: other seconds
    row.seconds *= 1.1;
    rows.push_back(row);
  }
  EXPECT_EQ(Calibration(rows).n_scenes(), 18u);
  EXPECT_TRUE(std::isinf(high())) << "the same eighteen";
  rows.push_back({way, 0.5, 0.2, 3, 3, "scene 0"});
  EXPECT_EQ(Calibration(rows).n_scenes(), 19u);
  EXPECT_NEAR(high(), 0.27, 1e-12);
  EXPECT_EQ(fewest_scenes(0.95), 19u);
  EXPECT_EQ(fewest_scenes(0.5), 1u);
  EXPECT_EQ(fewest_scenes(0.98), 49u);
}

Candidate candidate(const std::string& method, double error, double seconds, std::int64_t bytes) {
  Candidate one;
  one.way.method = method;
  one.error = {error / 2, error / 4, error};
  one.seconds = {seconds / 2, seconds / 4, seconds};
  one.bytes = bytes;
  return one;
}

/// By high ends: a 50 % in 1 s and 1 byte, b 10 % in 2 s and 8, c 5 % in 4 s and 4, d 1 % in 8 s and 2.
Choice synthetic(double error, double seconds, std::optional<std::int64_t> bytes = {}) {
  Choice choice;
  choice.wish.error = error;
  choice.wish.seconds = seconds;
  choice.wish.bytes = bytes;
  choice.candidates = {candidate("a", 0.5, 1, 1), candidate("b", 0.1, 2, 8), candidate("c", 0.05, 4, 4),
                       candidate("d", 0.01, 8, 2)};
  pick(choice);
  return choice;
}

// Analytic: read off the four candidates above.
TEST(PickAnalytic, TakesTheCheapestThatMeets) {
  EXPECT_EQ(synthetic(0.2, 10).chosen->way.method, "b");
  EXPECT_EQ(synthetic(0.1, 2).chosen->way.method, "b") << "equal is met";
  EXPECT_EQ(synthetic(0.03, 10).chosen->way.method, "d");
  EXPECT_EQ(synthetic(0.9, 1).chosen->way.method, "a");
  EXPECT_FALSE(synthetic(0.2, 10).most_exact_in_time);
}

TEST(PickAnalytic, MemoryIsALimit) {
  EXPECT_EQ(synthetic(0.2, 10, 4).chosen->way.method, "c");
  EXPECT_EQ(synthetic(0.2, 10, 3).chosen->way.method, "d");
  const Choice none = synthetic(0.2, 10, 1);
  EXPECT_FALSE(none.chosen);
  EXPECT_EQ(none.most_exact_in_time->way.method, "a") << "the only one that fits";
  EXPECT_FALSE(none.quickest_to_error);
}

TEST(PickAnalytic, WhereNoneMeetsTheNearestAreNamed) {
  const Choice none = synthetic(0.03, 5);
  EXPECT_FALSE(none.chosen);
  EXPECT_EQ(none.most_exact_in_time->way.method, "c");
  EXPECT_EQ(none.quickest_to_error->way.method, "d");
  const Choice nothing = synthetic(0.001, 0.5);
  EXPECT_FALSE(nothing.chosen || nothing.most_exact_in_time || nothing.quickest_to_error);
}

const std::string header = "scene,nodes,method,halvings,tolerance,status,total_s,relative_l2,predicted_error,"
                           "predicted_s,reference_l2\n";

// Contract: columns by name, quoted cells, and rows without measurement passed over.
TEST(TradeTableContract, IsReadByNamesOfColumns) {
  const auto rows =
      parse_trade_table(header + "\"a, \"\"b\"\"\",9,coupled,-1,0.01,done,0.5,0.1,0.2,0.25,0.01\n"
                                 "x,9,limits,0,,done,0.001,0.6,0.5,0.002,0.7\n"
                                 "x,9,relaxed,0,0.1,refused,,,,,0.7\n"
                                 "x,9,sweep,0,0.1,done,0.1,0.3,,,0.7\n"
                                 "y,9,coupled,0,0.1,done,0.1,0.3,0.2,0.1,\n",
                        "t.csv");
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].way, way);
  EXPECT_EQ(rows[0].seconds, 0.5);
  EXPECT_EQ(rows[0].error, 0.1);
  EXPECT_EQ(rows[0].predicted_error, 0.2);
  EXPECT_EQ(rows[0].predicted_seconds, 0.25);
  EXPECT_EQ(rows[1].way, (Way{"limits", 0, {}}));
  EXPECT_EQ(rows[1].error, 0.7) << "the reference's own";
}

TEST(TradeTableContract, EveryFaultIsReportedWithItsLine) {
  const auto faults = test::faults_found_by([] {
    (void)parse_trade_table(header + "a,9,coupled,x,0.01,done,0.5,0.1,0.2,0.25,0.01\nb,coupled\n"
                                     "a,9,coupled,0,0.01,done,soon,0.1,0.2,0.25,0.01\n",
                            "t.csv");
  });
  ASSERT_EQ(faults.size(), 3u);
  EXPECT_TRUE(test::says(faults[0], {.line = 2, .key = "halvings"}));
  EXPECT_TRUE(test::says(faults[1], {.line = 3}));
  EXPECT_TRUE(test::says(faults[2], {.line = 4, .found = "\"soon\""}));
  for (const std::string halvings : {"1e300", "11", "0.5", "nan"})
    EXPECT_THROW((void)parse_trade_table(
                     header + "a,9,coupled," + halvings + ",0.01,done,0.5,0.1,0.2,0.25,0.01\n", "t.csv"),
                 InputError)
        << halvings;
  EXPECT_TRUE(parse_trade_table(header + "a,9,coupled,0,0.01,done,inf,0.1,0.2,0.25,0.01\n", "t.csv").empty());
  EXPECT_THROW((void)parse_trade_table("a,b\n1,2\n", "t.csv"), InputError);
  EXPECT_THROW((void)parse_trade_table("", "t.csv"), InputError);
  EXPECT_THROW((void)read_trade_table("none/such.csv"), InputError);
}

// Contract: what choose promises rests on enough scenes.
TEST(TradeTableContract, TheBuiltInOneSaysEnoughAboutEveryMethod) {
  const auto rows = built_in_trade_table();
  const Calibration calibration(rows);
  // Of quadratic elements on the scene's own lattice a reference that is better still is dear: there are few.
  const std::vector<std::pair<std::string, int>> least{
      {"limits", 4}, {"relaxed", 8}, {"coupled", 8}, {"fem_q1", 3}, {"fem_q2", 2}};
  for (const auto& [method, ways] : least) {
    int known = 0;
    for (const Way& one : calibration.ways())
      known += one.method == method && std::isfinite(calibration.error(one, 1, 0.95).high) &&
               std::isfinite(calibration.seconds(one, 1, 0.95).high);
    EXPECT_GE(known, ways) << method;
  }
}

std::string box(const std::string& cells, const std::string& by, const std::string& poisson_ratio = "0.3") {
  return test::box_text(cells, "{ youngs_modulus = \"10 kPa\", poisson_ratio = " + poisson_ratio + " }") +
         test::hold_text() + test::move_text(by);
}

// Analytic: a bar is straight on any lattice, so nothing is left of its discretisation, and nothing is known.
TEST(ProbesAnalytic, ALineHasNoDiscretisationError) {
  Lattices lattices(box("[16]", "[\"1 mm\"]"), "line.toml");
  const Probes probes = probe(lattices, {});
  EXPECT_LT(probes.difference, 1e-3) << "but for the tolerance";
}

// Analytic: twice as fine halves the discretisation error, times grow with the nodes; squares of errors add
// up.
TEST(ProbesAnalytic, RawPredictionsFollowTheirRules) {
  Probes probes;
  probes.halvings = -1;
  probes.difference = 0.2;
  probes.nodes = 100;
  probes.of["coupled"] = {0, 0.01, {}};
  probes.of["relaxed"] = {0.3, 0.002, {}};
  probes.of["limits"] = {0, 0, "limits carry no loads"};
  const RawPrediction coupled = predict_raw(probes, {"coupled", 0, 1e-9}, nullptr, 800);
  EXPECT_NEAR(*coupled.error, 0.1, 1e-12);
  EXPECT_DOUBLE_EQ(*coupled.seconds, 0.08);
  EXPECT_NEAR(*predict_raw(probes, {"relaxed", -2, 0.0}, nullptr, 12).error, 0.5, 1e-12) << "0.4 and 0.3";
  EXPECT_FALSE(predict_raw(probes, {"limits", 0, {}}, nullptr, 800).error);
  EXPECT_FALSE(predict_raw(probes, {"sweep", 0, 1e-2}, nullptr, 800).error);
}

// Contract: limits that bind are the model's error, not the lattice's.
TEST(ProbesContract, BindingLimitsCountAsErrorOfTheModel) {
  const std::string pull = box("[8, 4, 4]", "[\"2 mm\", 0, 0]");
  Lattices free(pull, "free.toml"),
      bound(pull + "[limits]\nfrom = \"given\"\nstretch = 1.3\ncompress = 0.8\nshear = 0.02\n", "bound.toml");
  const Probes of_free = probe(free, {}), of_bound = probe(bound, {});
  EXPECT_EQ(of_free.difference, of_bound.difference) << "elasticity is the same";
  EXPECT_LT(of_free.of.at("coupled").model_error, 2e-3);
  EXPECT_GT(of_bound.of.at("coupled").model_error, 0.01);
}

/// A plate of two cells, held at one end, under its weight.
std::string plate(int cells, const std::string& poisson_ratio) {
  const std::string n = std::to_string(cells);
  return "[specimen]\nshape = \"box\"\ncells = [" + n + ", " + n +
         ", 2]\nspacing = \"1 mm\"\nmaterial = { youngs_modulus = \"1 MPa\", poisson_ratio = " +
         poisson_ratio + " }\n[[hold]]\nwhere = \"x-\"\n[[load]]\ngravity = [0, 0, -1]\n";
}

// Contract: lattices on which a plate is one cell thick, and alike wrong, are no probes, and no ways.
TEST(ProbesContract, LatticesThatHaveLostTheBodyAreNotAsked) {
  Lattices thick(box("[12, 8, 8]", "[\"1 mm\", 0, 0]"), "thick.toml"), thin(plate(12, "0.45"), "thin.toml"),
      film(box("[12, 8, 1]", "[\"1 mm\", 0, 0]"), "film.toml");
  const Probes of_thick = probe(thick, {}), of_thin = probe(thin, {}), of_film = probe(film, {});
  EXPECT_EQ(of_thick.halvings, -1);
  EXPECT_TRUE(of_thick.lost.empty() && of_thick.unlike.empty() && !of_thick.growth);
  EXPECT_EQ(of_thin.halvings, 2) << "two, four and eight cells thick";
  EXPECT_TRUE(of_thin.lost.contains(-1) && of_thin.lost.contains(-2));
  EXPECT_EQ(of_thin.unlike.size(), 2u) << "loads and slenderness";
  EXPECT_TRUE(test::has(of_film.why_not, "1 cells thick"));
}

/// Within 100 s, by the table that is built in.
Choice ask_for(Lattices& lattices, const char* quantity, double error) {
  Wish wish;
  wish.error = error;
  wish.seconds = 100;
  wish.of = quantity_named(quantity).value();
  return choose(lattices, wish, Calibration(built_in_trade_table()), {});
}

/// The scene as the chosen way asks it.
Scene chosen_scene(Lattices& lattices, const Choice& choice) {
  const Way& chosen = choice.chosen->way;
  Scene scene = *lattices.at(chosen.halvings).scene;
  if (chosen.tolerance)
    scene.relaxation.tolerance = *chosen.tolerance;
  return scene;
}

// Oracle: quadratic elements on cells of half the side. Twice and four times the spacing agreed with each
// other, and were 19 % off.
TEST(ChooseOracle, APlateUnderGravityIsPromisedWhatItKeeps) {
  Lattices lattices(plate(20, "0.45"), "plate.toml");
  const Choice choice = ask_for(lattices, "displacement", 0.2);
  ASSERT_TRUE(choice.chosen) << choice.probes.why_not;
  EXPECT_GE(choice.chosen->way.halvings, 0);
  const Scene fine = refined(lattices.scene());
  const Displacement truth =
      at_coarse_nodes(lattices.scene(), fine, answer_by(fine, "fem_q2", {}).displacement);
  const Scene asked = chosen_scene(lattices, choice);
  const Answer answer = answer_by(asked, choice.chosen->way.method, {});
  const double error =
      compare(lattices.scene(), between_lattices(asked, answer.displacement, lattices.scene()), truth)
          .relative_l2;
  EXPECT_LE(error, choice.chosen->error.high);
}

// Contract: thin matter bends as plates do on every lattice, so lattices of a plate approach each other.
TEST(ChooseContract, LatticesOfAThinPlateApproachEachOther) {
  Lattices lattices(plate(12, "0.49"), "plate.toml");
  const Choice choice = ask_for(lattices, "displacement", 0.2);
  EXPECT_TRUE(choice.chosen) << choice.probes.why_not;
}

// Analytic: a point that is moved drags along a field that is as wide as the lattice's spacing (Kelvin 1848:
// displacement falls as 1 over distance), so answers of finer and finer lattices differ by as much as before.
TEST(ChooseAnalytic, LatticesThatDoNotApproachEachOtherPromiseNothing) {
  Lattices lattices(
      test::box_text("[12, 12, 12]") + test::hold_text("z-") +
          "[[move]]\nwhere = { box = [[\"5.9 mm\", \"5.9 mm\", \"11.9 mm\"], [\"6.1 mm\", \"6.1 mm\", "
          "\"12.1 mm\"]] }\nby = [0, 0, \"-1 mm\"]\n[[load]]\ngravity = [0, 0, -1e-6]\n",
      "point.toml");
  const Choice choice = ask_for(lattices, "displacement", 0.2);
  EXPECT_FALSE(choice.chosen);
  EXPECT_TRUE(test::has(choice.probes.why_not, "do not approach each other"));
}

// Contract: a scene file of another lattice is that lattice.
TEST(LatticesContract, TheTextOfALatticeIsThatLattice) {
  const Lattices lattices(box("[12, 6, 6]", "[0, 0, \"1 mm\"]"), "bent.toml");
  Lattices asked(box("[12, 6, 6]", "[0, 0, \"1 mm\"]"), "bent.toml");
  for (const int halvings : {-1, 0, 1}) {
    const auto text = lattices.text(halvings, 0.01);
    ASSERT_TRUE(text) << halvings;
    const Scene read = parse_scene(*text, "bent.toml"), expected = *asked.at(halvings).scene;
    EXPECT_EQ(read.specimen.grid.cells(), expected.specimen.grid.cells());
    EXPECT_EQ(read.prescribed.size(), expected.prescribed.size());
    EXPECT_EQ(read.relaxation.tolerance, 0.01);
  }
  const Lattices round(
      "[specimen]\nshape = \"ellipsoid\"\ncells = [8, 8, 8]\nspacing = \"1 mm\"\nmaterial = { "
      "youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n[[hold]]\nwhere = \"x-\"\n",
      "round.toml");
  EXPECT_FALSE(round.text(1, {})) << "its finer lattice has the staircase of the coarse one";
}

TEST(ChooseContract, TooFewScenesAreSaid) {
  Lattices lattices(box("[12, 6, 6]", "[0, 0, \"1 mm\"]"), "bent.toml");
  std::vector<StoredRow> rows;
  for (int i = 0; i < 3; ++i)
    rows.push_back({way, 0.1, 0.1, 3, 3, "scene " + std::to_string(i)});
  Wish wish;
  wish.error = 0.5;
  wish.seconds = 100;
  const Choice choice = choose(lattices, wish, Calibration(rows), {});
  EXPECT_FALSE(choice.chosen);
  const std::string text = table(lattices.scene(), choice);
  EXPECT_TRUE(test::has(text, "the table holds 3 different scenes"));
  EXPECT_TRUE(test::has(text, "at least 19"));
}

TEST(ChooseContract, AWishWithRoomIsMetAndOneWithoutIsNot) {
  Lattices lattices(box("[12, 6, 6]", "[0, 0, \"1 mm\"]"), "bent.toml");
  const Choice easy = ask_for(lattices, "displacement", 0.2);
  ASSERT_TRUE(easy.chosen);
  EXPECT_TRUE(easy.chosen->meets(easy.wish));
  for (std::size_t i = 1; i < easy.candidates.size(); ++i)
    EXPECT_LE(easy.candidates[i - 1].seconds.median, easy.candidates[i].seconds.median);
  const Choice impossible = ask_for(lattices, "displacement", 1e-7);
  EXPECT_FALSE(impossible.chosen);
  EXPECT_TRUE(impossible.most_exact_in_time);
  EXPECT_EQ(json(lattices.scene(), impossible)["chosen"], nullptr);
}

// Promises of force, energy and stress.

// Analytic: 3, 4 from 0, 0 is 5 off; over a length of 10.
TEST(QuantityAnalytic, DifferencesAreThoseOfLengths) {
  const Quantity quantity = quantity_of("made up", [](const Scene&, const Answer& answer) {
    return answer.iterations == 0 ? std::vector<double>{3, 4} : std::vector<double>{6, 8};
  });
  const Scene scene;
  Answer coarse, fine;
  fine.iterations = 1;
  EXPECT_DOUBLE_EQ(quantity.difference({&scene, &coarse}, {&scene, &fine}).value(), 0.5);
  EXPECT_DOUBLE_EQ(quantity.difference({&scene, &fine}, {&scene, &fine}).value(), 0);
  EXPECT_FALSE(quantity.is_displacement());
}

TEST(QuantityContract, NamesAreThoseOfTheCommandLine) {
  EXPECT_TRUE(quantity_named("displacement").value().is_displacement());
  for (const char* name : {"force", "energy", "stress"})
    EXPECT_FALSE(quantity_named(name).value().is_displacement()) << name;
  EXPECT_FALSE(quantity_named("Force"));
  EXPECT_EQ(every_quantity().size(), 4u);
}

// Analytic: without lateral contraction a pulled bar's force is E A eps on any lattice.
TEST(ChooseQuantityAnalytic, AForceThatEveryLatticeKnowsIsPromisedOnTheCoarsest) {
  Lattices lattices(box("[16, 8, 8]", "[\"1 mm\", 0, 0]", "0"), "bar.toml");
  const Choice choice = ask_for(lattices, "force", 0.05);
  ASSERT_TRUE(choice.chosen) << choice.probes.why_not;
  EXPECT_EQ(choice.chosen->way.method, "coupled");
  EXPECT_LE(choice.chosen->error.median, 0.03);
  const Scene asked = chosen_scene(lattices, choice);
  const Mechanics found = resultants_of(asked, answer_by(asked, "coupled", {}));
  const double force = 10e3 * 64e-6 / 16;
  EXPECT_NEAR(found.moves.at(0).force[0], force, choice.chosen->error.high * force);
}

// Oracle: quadratic elements on cells of half the side.
TEST(ChooseQuantityOracle, AForceIsPromisedWhatItKeeps) {
  Lattices lattices(box("[16, 8, 8]", "[0, 0, \"1 mm\"]", "0.45"), "bent.toml");
  const Scene& scene = lattices.scene();
  const Scene fine = refined(scene);
  Answer truth = answer_by(fine, "fem_q2", {});
  bring_to_coarse(scene, fine, truth);
  for (const char* quantity : {"force", "energy", "stress"}) {
    const Choice choice = ask_for(lattices, quantity, 0.4);
    ASSERT_TRUE(choice.chosen) << quantity << ": " << choice.probes.why_not;
    const Scene asked = chosen_scene(lattices, choice);
    const Answer answer = answer_by(asked, choice.chosen->way.method, {});
    const auto error = choice.wish.of.difference({&asked, &answer}, {&scene, &truth});
    EXPECT_LE(error.value(), choice.chosen->error.high) << quantity;
    EXPECT_GT(error.value(), 1e-4) << "something to be promised";
  }
}

TEST(ChooseQuantityContract, SaysOnWhatThePromiseRests) {
  Lattices lattices(box("[16, 8, 8]", "[0, 0, \"1 mm\"]", "0.3"), "bent.toml");
  const Choice of_force = ask_for(lattices, "force", 0.4),
               of_displacement = ask_for(lattices, "displacement", 0.4);
  ASSERT_TRUE(of_force.chosen && of_displacement.chosen);
  for (const Candidate& candidate : of_force.candidates)
    EXPECT_EQ(candidate.way.method, "coupled");
  const auto json_of_force = json(lattices.scene(), of_force);
  EXPECT_EQ(json_of_force["wish"]["of"], "force");
  EXPECT_EQ(json_of_force["rests_on"], "three lattices");
  EXPECT_EQ(json(lattices.scene(), of_displacement)["wish"]["of"], "displacement");
  EXPECT_EQ(json(lattices.scene(), of_displacement)["rests_on"], "table");
  const std::string text = table(lattices.scene(), of_force);
  EXPECT_TRUE(test::has(text, "the table holds no errors of force: three lattices speak for it"));
  EXPECT_TRUE(
      test::has(text, "limits at 1 times the spacing: of coupled alone can an error of force be promised"));
}

TEST(ChooseQuantityContract, AQuantityThatIsNotThereIsNamed) {
  Lattices lattices(test::box_text("[16, 8, 8]") + test::hold_text(), "still.toml");
  Wish wish;
  wish.error = 0.1;
  wish.seconds = 100;
  wish.of = quantity_of("length", [](const Scene&, const Answer&) { return std::vector<double>{}; });
  const Choice choice = choose(lattices, wish, Calibration(built_in_trade_table()), {});
  EXPECT_FALSE(choice.chosen);
  EXPECT_TRUE(test::has(choice.probes.why_not, "no length to compare"));
}

} // namespace
} // namespace maille::studies
