#include "maille/materials/library.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace maille {

TEST(LibraryContract, EveryTissueIsWholeAndValid) {
  ASSERT_GE(material_library().size(), 10U);
  std::set<std::string> names;
  for (const LibraryEntry& entry : material_library()) {
    SCOPED_TRACE(entry.material.name);
    EXPECT_TRUE(names.insert(entry.material.name).second);
    EXPECT_FALSE(entry.title.empty());
    EXPECT_FALSE(entry.state.empty());
    EXPECT_FALSE(entry.species.empty());
    EXPECT_FALSE(entry.source.empty());
    EXPECT_TRUE(entry.verified || !entry.note.empty()) << "what is not verified has to say why";
    EXPECT_GT(entry.material.density, 0);
    EXPECT_TRUE(violated_inequalities(entry.material.elasticity).empty());
    const Matrix6 C = stiffness(entry.material.elasticity);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Matrix6>(C).eigenvalues().minCoeff(), 0);
    if (entry.material.damage && entry.material.limits) {
      EXPECT_LT(entry.material.limits->stretch[0], entry.material.damage->stretch[0])
          << "limits of torn tissue";
    }
    if (entry.material.limits) {
      EXPECT_NE(entry.note.find("limits are a choice"), std::string::npos);
    }
  }
}

TEST(LibraryContract, SortedAndFoundByName) {
  const auto& library = material_library();
  EXPECT_TRUE(
      std::is_sorted(library.begin(), library.end(), [](const LibraryEntry& a, const LibraryEntry& b) {
        return a.material.name < b.material.name;
      }));
  // Truth: the names that the scenes use.
  for (const char* name :
       {"muscle/vastus_lateralis", "muscle/soleus", "muscle/gastrocnemius", "muscle/tibialis_anterior",
        "muscle/strongly_anisotropic", "fat/subcutaneous", "liver/parenchyma", "brain/grey_matter",
        "brain/white_matter", "tendon/tibialis_anterior", "bone/cortical_tibia", "phantom/silicone",
        "cartilage/femoral_condyle", "skin/dermis"}) {
    const LibraryEntry* const entry = find_material(name);
    ASSERT_NE(entry, nullptr) << name;
    EXPECT_EQ(entry->material.name, name);
  }
  EXPECT_EQ(find_material("muscle/nonsense"), nullptr);
  EXPECT_EQ(find_material(""), nullptr);
}

TEST(LibraryContract, AMisspeltNameIsMetWithTheNearest) {
  ASSERT_FALSE(similar_material_names("muscle/solues").empty());
  EXPECT_EQ(similar_material_names("muscle/solues").front(), "muscle/soleus");
  EXPECT_EQ(similar_material_names("Soleus").front(), "muscle/soleus");
  EXPECT_EQ(similar_material_names("tibialis_anterior"),
            (std::vector<std::string>{"muscle/tibialis_anterior", "tendon/tibialis_anterior"}));
  EXPECT_EQ(similar_material_names("muscle", 2).size(), 2U);
  EXPECT_TRUE(similar_material_names("soleus", 0).empty());
  EXPECT_TRUE(similar_material_names("unobtainium").empty());
}

TEST(LibraryContract, AFaultyTissueTellsAllItsFaults) {
  const char* const text = R"(title = "t"
state = ""
species = "s"
verified = 1
density = "-1 kg/m^3"
colour = "red"
[elasticity]
youngs_modulus = "1 mm"
poisson_ratio = 0.3
density = 3
[limits]
stretch = 0.5
compress = 1
shear = 0
give = 1
[damage]
stretch = 0.9
of = "t"
verified = true
cause = "age"
)";
  try {
    parse_library_entry(text, "t.toml", "t");
    FAIL() << "nothing was thrown";
  } catch (const InputError& error) {
    std::multiset<std::pair<int, std::string>> found;
    for (const Fault& fault : error.faults()) {
      EXPECT_EQ(fault.file, "t.toml");
      found.emplace(fault.line, fault.key);
    }
    // Truth: the text above, line by line; `source` is missing and has the line of its table.
    EXPECT_EQ(found, (std::multiset<std::pair<int, std::string>>{{1, "source"},
                                                                 {2, "state"},
                                                                 {4, "verified"},
                                                                 {5, "density"},
                                                                 {6, "colour"},
                                                                 {8, "elasticity.youngs_modulus"},
                                                                 {10, "elasticity.density"},
                                                                 {12, "limits.stretch"},
                                                                 {15, "limits.give"},
                                                                 {16, "damage.source"},
                                                                 {17, "damage.stretch"},
                                                                 {20, "damage.cause"}}));
  }
}

} // namespace maille
