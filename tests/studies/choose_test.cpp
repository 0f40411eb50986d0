// Probes of small scenes, and what they promise.

#include "choose/choose.hpp"
#include "compare/methods.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"
#include "support/kit.hpp"

#include <nlohmann/json.hpp>

namespace maille::studies {
namespace {

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

/// Checks on every lattice that `coupled` is within the promise there: twice what three lattices tell.
template<class Error>
void expect_promises_kept(Lattices& lattices, const Probes& probes, int finest, const Error& error_of) {
  ASSERT_TRUE(probes.why_not.empty() && probes.growth) << probes.why_not;
  int n_kept = 0;
  for (const auto& entry : prospects(lattices, probes, -2, finest)) {
    if (entry["method"] != "coupled" || entry.contains("why_not"))
      continue;
    Scene asked = *lattices.at(entry["halvings"].get<int>()).scene;
    asked.relaxation.tolerance = 1e-3;
    EXPECT_LE(error_of(asked, answer_by(asked, "coupled", {})), 2 * entry["error"].get<double>())
        << probes.quantity << " on " << entry["halvings"];
    ++n_kept;
  }
  EXPECT_GE(n_kept, 2);
}

// Oracle: quadratic elements on cells of half the side. Twice and four times the spacing agreed with each
// other, and were 19 % off.
TEST(ChooseOracle, APlateUnderGravityIsPromisedWhatItKeeps) {
  Lattices lattices(plate(20, "0.45"), "plate.toml");
  const Scene fine = refined(lattices.scene());
  const Displacement truth =
      at_coarse_nodes(lattices.scene(), fine, answer_by(fine, "fem_q2", {}).displacement);
  expect_promises_kept(lattices, probe(lattices, {}), 1, [&](const Scene& asked, const Answer& answer) {
    return compare(lattices.scene(), between_lattices(asked, answer.displacement, lattices.scene()), truth)
        .relative_l2;
  });
}

// Contract: thin matter bends as plates do on every lattice, so lattices of a plate approach each other.
TEST(ChooseContract, LatticesOfAThinPlateApproachEachOther) {
  Lattices lattices(plate(12, "0.49"), "plate.toml");
  const Probes probes = probe(lattices, {});
  EXPECT_TRUE(probes.why_not.empty() && probes.growth) << probes.why_not;
}

// Analytic: a point that is moved drags along a field that is as wide as the lattice's spacing (Kelvin 1848:
// displacement falls as 1 over distance), so answers of finer and finer lattices differ by as much as before.
TEST(ChooseAnalytic, LatticesThatDoNotApproachEachOtherPromiseNothing) {
  Lattices lattices(
      test::box_text("[12, 12, 12]") + test::hold_text("z-") +
          "[[move]]\nwhere = { box = [[\"5.9 mm\", \"5.9 mm\", \"11.9 mm\"], [\"6.1 mm\", \"6.1 mm\", "
          "\"12.1 mm\"]] }\nby = [0, 0, \"-1 mm\"]\n[[load]]\ngravity = [0, 0, -1e-6]\n",
      "point.toml");
  EXPECT_TRUE(test::has(probe(lattices, {}).why_not, "do not approach each other"));
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
  const Probes probes = probe_quantity(lattices, quantity_named("force").value(), {});
  ASSERT_TRUE(probes.why_not.empty()) << probes.why_not;
  const RawPrediction raw = predict_raw(probes, {"coupled", -2, 1e-3}, nullptr, 1);
  EXPECT_LE(raw.error.value(), 0.03);
  const Scene& asked = *lattices.at(-2).scene;
  const Mechanics found = resultants_of(asked, answer_by(asked, "coupled", {}));
  const double force = 10e3 * 64e-6 / 16;
  EXPECT_NEAR(found.moves.at(0).force[0], force, 2 * *raw.error * force);
}

// Oracle: quadratic elements on cells of half the side.
TEST(ChooseQuantityOracle, AForceIsPromisedWhatItKeeps) {
  Lattices lattices(box("[16, 8, 8]", "[0, 0, \"1 mm\"]", "0.45"), "bent.toml");
  const Scene& scene = lattices.scene();
  const Scene fine = refined(scene);
  Answer truth = answer_by(fine, "fem_q2", {});
  bring_to_coarse(scene, fine, truth);
  for (const char* name : {"force", "energy", "stress"}) {
    const Quantity quantity = quantity_named(name).value();
    expect_promises_kept(lattices, probe_quantity(lattices, quantity, {}), 0,
                         [&](const Scene& asked, const Answer& answer) {
                           const auto error = quantity.difference({&asked, &answer}, {&scene, &truth});
                           EXPECT_GT(error.value(), 1e-4) << "something to be promised";
                           return error.value();
                         });
  }
}

TEST(ChooseQuantityContract, OfCoupledAloneSomethingIsPromised) {
  Lattices lattices(box("[16, 8, 8]", "[0, 0, \"1 mm\"]", "0.3"), "bent.toml");
  const Probes probes = probe_quantity(lattices, quantity_named("force").value(), {});
  for (const auto& entry : prospects(lattices, probes, 0, 0)) {
    const std::string why_not = entry.value("why_not", "");
    EXPECT_EQ(why_not.empty(), entry["method"] == "coupled");
    EXPECT_TRUE(why_not.empty() ||
                test::has(why_not, entry["method"] == "limits" || entry["method"] == "relaxed"
                                       ? "of coupled alone can an error of force be promised"
                                       : "it holds no errors of force"));
  }
}

TEST(ChooseQuantityContract, AQuantityThatIsNotThereIsNamed) {
  Lattices lattices(test::box_text("[16, 8, 8]") + test::hold_text(), "still.toml");
  const Quantity length =
      quantity_of("length", [](const Scene&, const Answer&) { return std::vector<double>{}; });
  EXPECT_TRUE(test::has(probe_quantity(lattices, length, {}).why_not, "no length to compare"));
}

} // namespace
} // namespace maille::studies
