// Promises of force, energy and stress.
#include "choose/choose.hpp"
#include "compare/methods.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "maille/scene/refined.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace maille::studies {
namespace {

std::string box(const std::string& cells, const std::string& by, const std::string& poisson_ratio) {
  return "[specimen]\nshape = \"box\"\ncells = " + cells +
         "\nspacing = \"1 mm\"\nmaterial = { youngs_modulus = \"10 kPa\", poisson_ratio = " + poisson_ratio +
         " }\n[[hold]]\nwhere = \"x-\"\n[[move]]\nwhere = \"x+\"\nby = " + by + "\n";
}

Choice ask_for(Lattices& lattices, const char* quantity, double error) {
  Wish wish;
  wish.error = error;
  wish.seconds = 100;
  wish.of = quantity_named(quantity).value();
  return choose(lattices, wish, Calibration(built_in_trade_table()), {});
}

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
  const LatticeScene lattice = lattices.at(choice.chosen->way.halvings);
  Scene asked = *lattice.scene;
  asked.relaxation.tolerance = choice.chosen->way.tolerance.value();
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
    const LatticeScene lattice = lattices.at(choice.chosen->way.halvings);
    Scene asked = *lattice.scene;
    asked.relaxation.tolerance = choice.chosen->way.tolerance.value();
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
  EXPECT_NE(text.find("the table holds no errors of force: three lattices speak for it"), std::string::npos)
      << text;
  EXPECT_NE(text.find("limits at 1 times the spacing: of coupled alone can an error of force be promised"),
            std::string::npos)
      << text;
}

TEST(ChooseQuantityContract, AQuantityThatIsNotThereIsNamed) {
  Lattices lattices("[specimen]\nshape = \"box\"\ncells = [16, 8, 8]\nspacing = \"1 mm\"\nmaterial = { "
                    "youngs_modulus = \"10 kPa\", poisson_ratio = 0.3 }\n[[hold]]\nwhere = \"x-\"\n",
                    "still.toml");
  Wish wish;
  wish.error = 0.1;
  wish.seconds = 100;
  wish.of = quantity_of("length", [](const Scene&, const Answer&) { return std::vector<double>{}; });
  const Choice choice = choose(lattices, wish, Calibration(built_in_trade_table()), {});
  EXPECT_FALSE(choice.chosen);
  EXPECT_NE(choice.probes.why_not.find("no length to compare"), std::string::npos) << choice.probes.why_not;
}

} // namespace
} // namespace maille::studies
