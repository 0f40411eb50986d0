/// Constants of the library's tissues against what was published.

#include "maille/materials/elasticity.hpp"
#include "maille/materials/library.hpp"
#include "maille/materials/material.hpp"
#include "materials/constants_and_faults.hpp"
#include "support/kit.hpp"

#include <Eigen/Dense>
#include <Eigen/Geometry>

namespace maille {
namespace {

const Material& material(std::string_view name) {
  const LibraryEntry* const entry = find_material(name);
  if (!entry)
    throw std::runtime_error("no such tissue: " + std::string(name));
  return entry->material;
}

double bulk_modulus_along(const ElasticConstants& constants, Eigen::Index axis) {
  return 1 / (3 * compliance(constants).row(axis).head<3>().sum());
}

// Truth: measured constants, and the table of ready-to-use sets derived from them, rounded as printed; the
// bulk moduli to whole kPa, which nu_cross of tibialis anterior shows most (25.4 there).
TEST(LibraryReference, MusclesHaveTheConstantsThatWereMeasuredAndTabulated) {
  struct Case {
    const char* name;
    double E_fibre, G_fibre, G_cross;                      // Guo et al. 2016, Knight et al. 2022 [Pa]
    double bulk_modulus, nu_fibre, nu_cross, G, condition; // tabulated [kPa]
  };
  for (const Case& muscle :
       {Case{"muscle/vastus_lateralis", 41800, 5770, 1930, 115, 0.4396, 0.9012, 1.94, 178},
        Case{"muscle/soleus", 6920, 1330, 1060, 27, 0.4566, 0.7113, 1.07, 74},
        Case{"muscle/gastrocnemius", 8220, 1300, 900, 26, 0.4473, 0.7818, 0.91, 86},
        Case{"muscle/tibialis_anterior", 9290, 1270, 1260, 25, 0.4390, 0.7320, 1.28, 60}}) {
    SCOPED_TRACE(muscle.name);
    const ElasticConstants& c = material(muscle.name).elasticity;
    // E_cross = 4 G_cross E_fibre / (E_fibre + G_cross), K = 20 max(G), and under pressure every axis gives
    // alike; the constants are rounded to three or four digits.
    EXPECT_NEAR(c.youngs_modulus[0], muscle.E_fibre, 1e-9);
    EXPECT_NEAR(c.youngs_modulus[1], 4 * muscle.G_cross * muscle.E_fibre / (muscle.E_fibre + muscle.G_cross),
                15);
    EXPECT_NEAR(c.G12, muscle.G_fibre, 1e-9);
    EXPECT_NEAR(bulk_modulus_along(c, 0), 20 * muscle.G_fibre, 0.01 * 20 * muscle.G_fibre);
    EXPECT_NEAR(bulk_modulus_along(c, 1), 20 * muscle.G_fibre, 0.03 * 20 * muscle.G_fibre);
    EXPECT_NEAR(material(muscle.name).density, 1050, 1e-9);
    EXPECT_EQ(c.nu12, muscle.nu_fibre);
    EXPECT_EQ(c.nu23, muscle.nu_cross);
    EXPECT_NEAR(c.G23 / 1e3, muscle.G, 0.006);
    const auto eigenvalues = Eigen::SelfAdjointEigenSolver<Matrix6>(stiffness(c)).eigenvalues();
    EXPECT_NEAR(eigenvalues(5) / eigenvalues(0), muscle.condition, 0.01 * muscle.condition);
    const auto nu = poisson_ratios_at(c.youngs_modulus, 1e3 * muscle.bulk_modulus);
    EXPECT_NEAR(nu[0], muscle.nu_fibre, 1.5e-3);
    EXPECT_NEAR(nu[1], muscle.nu_fibre, 1.5e-3);
    EXPECT_NEAR(nu[2], muscle.nu_cross, 2e-3);
  }
}

TEST(NearlyIncompressibleReference, VastusLateralisAtHundredTimesItsShearModulus) {
  // Truth: the same table, K = 577 kPa: nu_fibre 0.4879, nu_cross 0.9097, G_cross 1.93 kPa, condition 896.
  const auto nu = poisson_ratios_at({41.8, 7.38, 7.38}, 577);
  EXPECT_NEAR(nu[0], 0.4879, 5.1e-5);
  EXPECT_EQ(nu[0], nu[1]);
  EXPECT_NEAR(nu[2], 0.9097, 1.1e-4);
  const auto c = ElasticConstants::transversely_isotropic(41.8, 7.38, 5.77, nu[0], nu[2]);
  EXPECT_NEAR(c.G23, 1.93, 0.006);
  const auto eigenvalues = Eigen::SelfAdjointEigenSolver<Matrix6>(stiffness(c)).eigenvalues();
  EXPECT_NEAR(eigenvalues(5) / eigenvalues(0), 896, 9);
}

TEST(NearlyIncompressibleAnalytic, PressureChangesNoShape) {
  // Truth: the definition; isotropic 1/2 - E / (6 K); incompressible nu_fibre 1/2, nu_cross 1 - E_cross / (2
  // E_fibre).
  for (const double nu : poisson_ratios_at({3e3, 3e3, 3e3}, 20e3))
    EXPECT_NEAR(nu, 0.5 - 3.0 / 120, 1e-14);
  const auto limit = poisson_ratios_at({447, 22.4, 22.4}, 1e15);
  EXPECT_NEAR(limit[0], 0.5, 1e-11);
  EXPECT_NEAR(limit[2], 1 - 22.4 / 894, 1e-11);
  const std::array<double, 3> E{20e3, 9e3, 5e3};
  const auto nu = poisson_ratios_at(E, 40e3);
  const ElasticConstants constants{E, nu[0], nu[1], nu[2], 1e3, 1e3, 1e3};
  for (Eigen::Index axis = 0; axis < 3; ++axis)
    EXPECT_NEAR(bulk_modulus_along(constants, axis), 40e3, 1e-7);
}

TEST(LibraryReference, DamageIsWhatWasPublished) {
  const auto damage = [](std::string_view name) { return find_material(name)->material.damage; };
  // Truth: PMC6925591, table 1: ultimate true strain 0.38; Garrett 1988: 72.7 % of the resting fibre length.
  ASSERT_TRUE(damage("liver/parenchyma"));
  EXPECT_NEAR(std::log(damage("liver/parenchyma")->stretch[0]), 0.38, 5e-4);
  EXPECT_TRUE(damage("liver/parenchyma")->verified);
  ASSERT_TRUE(damage("muscle/tibialis_anterior"));
  EXPECT_EQ(damage("muscle/tibialis_anterior")->stretch[0], 1.727);
  for (const char* muscle : {"muscle/vastus_lateralis", "muscle/soleus", "muscle/gastrocnemius"}) {
    ASSERT_TRUE(damage(muscle)) << muscle;
    EXPECT_EQ(damage(muscle)->stretch, (std::array{1.727, 1.727, 1.727}))
        << "the least of Garrett's three muscles";
    EXPECT_TRUE(damage(muscle)->of.starts_with("no figure for this muscle was found"));
  }
  // A teaching source only.
  ASSERT_TRUE(damage("tendon/tibialis_anterior"));
  EXPECT_FALSE(damage("tendon/tibialis_anterior")->verified);
}

TEST(LibraryReference, SkinIsWithinThePublishedRange) {
  const LibraryEntry* const skin = find_material("skin/dermis");
  ASSERT_NE(skin, nullptr);
  const ElasticConstants& c = skin->material.elasticity;
  // Truth: 5 kPa to 140 MPa over methods, along Langer's lines up to twice that across (Kalra 2016,
  // Geerligs 2011, Joodaki 2018); 1090 kg/m^3 (PMC3233242, table 3); K = 20 G_fibre as its note says.
  for (const double E : c.youngs_modulus) {
    EXPECT_GE(E, 5e3);
    EXPECT_LE(E, 140e6);
  }
  EXPECT_LE(c.youngs_modulus[0] / c.youngs_modulus[1], 2);
  EXPECT_NEAR(bulk_modulus_along(c, 0), 20 * c.G12, 1e-6 * c.G12);
  EXPECT_NEAR(bulk_modulus_along(c, 1), 20 * c.G12, 1e-6 * c.G12);
  EXPECT_EQ(skin->material.density, 1090);
  EXPECT_FALSE(skin->verified) << "its moduli are a choice";
}

TEST(LibraryReference, DensitiesAreThoseOfOneTable) {
  // Truth: PMC3233242, table 3 [kg/m^3].
  for (const auto& [group, density] :
       {std::pair{"muscle/", 1050.0}, std::pair{"fat/", 950.0}, std::pair{"skin/", 1090.0},
        std::pair{"liver/", 1060.0}, std::pair{"brain/", 1040.0}, std::pair{"tendon/", 1130.0},
        std::pair{"heart/", 1060.0}}) {
    int found = 0;
    for (const LibraryEntry& entry : material_library()) {
      if (entry.material.name.starts_with(group)) {
        EXPECT_EQ(entry.material.density, density) << entry.material.name;
        ++found;
      }
    }
    EXPECT_GT(found, 0) << group;
  }
}

TEST(LibraryAnalytic, IsotropicTissuesHaveTheirShearModulus) {
  struct Case {
    const char* name;
    double G; // [Pa], see the files' sources
  };
  for (const Case& tissue :
       {Case{"fat/subcutaneous", 3040}, Case{"liver/parenchyma", 1800}, Case{"brain/grey_matter", 740},
        Case{"brain/white_matter", 1030}, Case{"brain/grey_matter_at_200_hz", 3100},
        Case{"brain/white_matter_at_200_hz", 2700}}) {
    const ElasticConstants& c = material(tissue.name).elasticity;
    EXPECT_NEAR(c.G12, tissue.G, 1e-3 * tissue.G) << tissue.name;
    EXPECT_NEAR(bulk_modulus_along(c, 0), 20 * tissue.G, 0.005 * 20 * tissue.G) << tissue.name;
  }
}

TEST(LibraryAnalytic, CorticalBoneHasThePublishedStiffness) {
  const Matrix6 C = stiffness(material("bone/cortical_tibia").elasticity) / 1e9;
  // Truth: Hoffmeister 2000, GPa, long axis 3: c11 19.5, c22 20.1, c33 30.9, c44 5.72, c55 5.17, c66 4.05,
  // c13 = c23 = 12.5, c12 = c11 - 2 c66 = 11.4. Here 3 -> 1, 1 -> 2, 2 -> 3. Ratios are rounded to three
  // digits.
  EXPECT_NEAR(C(0, 0), 30.9, 0.1);
  EXPECT_NEAR(C(1, 1), 19.5, 0.1);
  EXPECT_NEAR(C(2, 2), 20.1, 0.1);
  EXPECT_NEAR(C(0, 1), 12.5, 0.1);
  EXPECT_NEAR(C(0, 2), 12.5, 0.1);
  EXPECT_NEAR(C(1, 2), 11.4, 0.1);
  EXPECT_NEAR(C(3, 3), 4.05, 1e-12); // plane 23 here is their 12
  EXPECT_NEAR(C(4, 4), 5.72, 1e-12); // 13 here is their 32
  EXPECT_NEAR(C(5, 5), 5.17, 1e-12); // 12 here is their 31
}

TEST(LibraryAnalytic, CartilageHasThePublishedAggregateModulus) {
  // Truth: the stiffness of a pull with the sides held is the aggregate modulus, 0.82 MPa.
  EXPECT_NEAR(stiffness(material("cartilage/femoral_condyle").elasticity)(0, 0), 0.82e6, 1e3);
}

TEST(LibraryReference, LawsAreThosePublished) {
  // Truth: FEBio's test mu02 (g3 is a choice), Land 2015, PMC6305050 table 2, Sims 2010.
  const auto law = [](std::string_view name) { return material(name).law.value(); };
  EXPECT_EQ(law("muscle/blemker_2005"), Law(Muscle{500, 500, 0.05, 6.6, 1.4, 1.4, 3e5, 0, 1e7, 667}));
  EXPECT_EQ(law("heart/land_2015"), Law(Guccione{2e3, 8, 2, 4, 4e5}));
  EXPECT_EQ(law("muscle/face_wu"), Law(MooneyRivlin{2500, 1175, 147e3}));
  EXPECT_NEAR(std::get<NeoHookean>(law("fat/subdermal_pig")).mu, 530, 0.1);
  for (const LibraryEntry& entry : material_library())
    EXPECT_TRUE(broken_rules(entry.material).empty()) << entry.material.name;
}

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
      EXPECT_TRUE(test::has(entry.note, "limits are a choice"));
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
  std::string found;
  for (const Fault& fault : test::faults_found_by([&] { parse_library_entry(text, "t.toml", "t"); }))
    found += fmt::format("{}:{} {}, ", fault.file, fault.line, fault.key);
  // Truth: the text above, line by line; `source` is missing and has the line of its table.
  EXPECT_EQ(found, "t.toml:1 source, t.toml:2 state, t.toml:4 verified, t.toml:5 density, t.toml:6 colour, "
                   "t.toml:8 elasticity.youngs_modulus, t.toml:10 elasticity.density, "
                   "t.toml:12 limits.stretch, t.toml:15 limits.give, t.toml:16 damage.source, "
                   "t.toml:17 damage.stretch, t.toml:20 damage.cause, ");
}

constexpr std::uint64_t limits_seed = 77;
constexpr int draws = 200;

NeighbourLimits nine_different_limits() {
  return {{1.1, 1.2, 1.3}, {0.9, 0.8, 0.7}, {{{0, 0.12, 0.13}, {0.21, 0, 0.23}, {0.31, 0.32, 0}}}};
}

void expect_near(const NeighbourLimits& found, const NeighbourLimits& expected, double tolerance) {
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_NEAR(found.stretch[a], expected.stretch[a], tolerance) << a;
    EXPECT_NEAR(found.compress[a], expected.compress[a], tolerance) << a;
    for (std::size_t b = 0; b < 3; ++b)
      EXPECT_NEAR(found.shear[a][b], expected.shear[a][b], tolerance) << a << b;
  }
}

TEST(TurnedLimitsAnalytic, NoTurnChangesNothing) {
  EXPECT_EQ(turned(nine_different_limits(), Eigen::Matrix3d::Identity()), nine_different_limits());
}

TEST(TurnedLimitsAnalytic, AThirdOfATurnAboutTheDiagonalCyclesTheAxes) {
  const Eigen::Matrix3d third =
      Eigen::AngleAxisd(2 * std::numbers::pi / 3, Eigen::Vector3d::Ones().normalized()).toRotationMatrix();
  // Truth: material axes 1, 2, 3 lie along object y, z, x, so x, y, z see 3, 1, 2. A turn that is not its own
  // inverse tells rows from columns.
  const NeighbourLimits expected{
      {1.3, 1.1, 1.2}, {0.7, 0.9, 0.8}, {{{0, 0.31, 0.32}, {0.13, 0, 0.12}, {0.23, 0.21, 0}}}};
  expect_near(turned(nine_different_limits(), third), expected, 1e-15);
}

TEST(TurnedLimitsAnalytic, EighthTurnAverages) {
  const Eigen::Matrix3d eighth =
      Eigen::AngleAxisd(std::numbers::pi / 4, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  const NeighbourLimits found = turned(nine_different_limits(), eighth);
  // Truth: the header's formula by hand, with R_xi^2 = R_yi^2 = 1/2 for i = 1, 2.
  EXPECT_NEAR(found.stretch[0], 1.15, 1e-15);
  EXPECT_NEAR(found.stretch[2], 1.3, 1e-15);
  EXPECT_NEAR(found.compress[1], 0.85, 1e-15);
  EXPECT_NEAR(found.shear[0][1], (0.12 + 0.21) / 2, 1e-15);
  EXPECT_NEAR(found.shear[0][2], (0.13 + 0.23) / 2, 1e-15);
  EXPECT_NEAR(found.shear[2][1], (0.31 + 0.32) / 2, 1e-15);
}

TEST(TurnedLimitsAnalytic, EqualLimitsStayEqualAndLegalOnesLegal) {
  SCOPED_TRACE(limits_seed);
  test::RandomMaterials random(limits_seed);
  const NeighbourLimits rigid;
  const NeighbourLimits equal{
      {1.3, 1.3, 1.3}, {0.7, 0.7, 0.7}, {{{0, 0.3, 0.3}, {0.3, 0, 0.3}, {0.3, 0.3, 0}}}};
  for (int i = 0; i < draws; ++i) {
    const Eigen::Matrix3d axes = random.rotation();
    EXPECT_EQ(turned(equal, axes), equal); // to the last bit: no limit may leak through round-off
    EXPECT_EQ(turned(rigid, axes), rigid);
  }
}

TEST(LinkComplianceAnalytic, IsTheInverseModuliAlongTheAxes) {
  const ElasticConstants c{{20e3, 9e3, 5e3}, 0.3, 0.2, 0.25, 4e3, 3e3, 2e3};
  const LinkCompliance solid = link_compliance(stiffness(c));
  // Truth: a pull along axis a alone stretches by 1/E_a, a shear of the plane ab gives 1/G_ab.
  EXPECT_NEAR(solid.axial[0], 1 / 20e3, 1e-17);
  EXPECT_NEAR(solid.axial[1], 1 / 9e3, 1e-17);
  EXPECT_NEAR(solid.axial[2], 1 / 5e3, 1e-17);
  EXPECT_NEAR(solid.shear[0][1], 1 / 4e3, 1e-17);
  EXPECT_NEAR(solid.shear[2][0], 1 / 3e3, 1e-17);
  EXPECT_NEAR(solid.shear[1][2], 1 / 2e3, 1e-17);
  EXPECT_EQ(solid.shear[2][1], solid.shear[1][2]);

  const LinkCompliance plane = link_compliance(reduced_stiffness(stiffness(c), 2, PlaneAssumption::stress));
  EXPECT_NEAR(plane.axial[1], 1 / 9e3, 1e-17);
  EXPECT_NEAR(plane.shear[1][0], 1 / 4e3, 1e-17);
  EXPECT_EQ(plane.axial[2], 0);
  EXPECT_EQ(plane.shear[0][2], 0);

  const LinkCompliance bar = link_compliance(reduced_stiffness(stiffness(c), 1, PlaneAssumption::stress));
  EXPECT_NEAR(bar.axial[0], 1 / 20e3, 1e-17);
  EXPECT_EQ(bar.axial[1], 0);
}

} // namespace
} // namespace maille
