/// `maille materials` as outside scripts see it.

#include "studies/commands/run_command.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace maille {
namespace {

using nlohmann::json;
using test::maille_command;

TEST(MaterialsCommandContract, ShowsATissueWithItsSourceAndDerivedConstants) {
  const json tissue = json::parse(maille_command("materials muscle/vastus_lateralis --json").out);
  EXPECT_EQ(tissue["name"], "muscle/vastus_lateralis");
  EXPECT_NEAR(tissue["youngs_modulus_pa"][0].get<double>(), 41.8e3, 1); // Knight et al. 2022
  EXPECT_FALSE(tissue["source"].get<std::string>().empty());
  EXPECT_GT(tissue["stiffness_eigenvalues_pa"][0], 0);
  EXPECT_NE(maille_command("materials").out.find("muscle/soleus"), std::string::npos);
  // The table of ready-to-use sets derived from Knight et al. 2022: K 577 kPa, nu_fibre 0.4879, nu_cross
  // 0.9097.
  ASSERT_EQ(tissue["nearly_incompressible"].size(), 2u);
  EXPECT_NEAR(tissue["nearly_incompressible"][1]["bulk_modulus_pa"].get<double>(), 577e3, 1e-6);
  EXPECT_NEAR(tissue["nearly_incompressible"][1]["poisson_ratio"][0].get<double>(), 0.4879, 1e-4);
  EXPECT_NEAR(tissue["nearly_incompressible"][1]["poisson_ratio"][2].get<double>(), 0.9097, 1.5e-4);
}

TEST(MaterialsCommandContract, SaysWhatIsNotVerified) {
  const auto says = [](const std::string& arguments, const char* words) {
    return maille_command("materials " + arguments).out.find(words) != std::string::npos;
  };
  EXPECT_TRUE(says("liver/parenchyma", "damage       stretch 1.462: "));
  EXPECT_TRUE(says("tendon/tibialis_anterior", "damage       stretch 1.08 (UNVERIFIED): "));
  // 1 / 1.462^2 and 1.462 - 1 / 1.462
  EXPECT_TRUE(
      says("liver/parenchyma", "compress 0.4678 (follows from the stretch), shear 12 0.778 (follows"));
  EXPECT_TRUE(says("skin/dermis", "NO: do not quote these numbers as fact"));
  const json all = json::parse(maille_command("materials --json").out);
  const std::string table = maille_command("materials").out;
  for (const json& tissue : all) { // in every table, not only in its own
    const auto line = table.find("\n" + tissue["name"].get<std::string>() + " ");
    ASSERT_NE(line, std::string::npos) << tissue["name"];
    const bool is_marked =
        table.substr(line + 1, table.find('\n', line + 1) - line).find("UNVERIFIED") != std::string::npos;
    EXPECT_EQ(is_marked, !tissue["verified"].get<bool>()) << tissue["name"];
  }
}

} // namespace
} // namespace maille
