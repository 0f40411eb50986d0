/// The lattice operator of a box of one material against the operator of any body.

#include "elastic/box/box_level.hpp"
#include "elastic/masked/block_matrix.hpp"
#include "elastic/masked/masked_kernel.hpp"
#include "elastic/model/lattice_elasticity.hpp"
#include "elastic/multigrid/chebyshev.hpp"
#include "support/bodies/scenes.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"
#include "support/vector_targets.hpp"

namespace maille::deform {
namespace {

enum class Matter { isotropic, aligned, turned };

Scene box_of(Matter matter, Index3 cells, Vec3 spacing) {
  Scene scene = test::box_scene(3, cells, spacing);
  if (matter == Matter::isotropic)
    scene.materials[0].elasticity = ElasticConstants::isotropic(10e3, 0.45);
  else
    scene.materials[0].elasticity = ElasticConstants::transversely_isotropic(60e3, 10e3, 7e3, 0.3, 0.4);
  if (matter == Matter::turned)
    scene.specimen.fibre = {0.48, 0.6, 0.64};
  return scene;
}

std::unique_ptr<BoxLevel> level_of(const Scene& scene, double unit, std::uint8_t fixed = 0) {
  std::array<std::vector<double>, 3> place;
  for (std::size_t a = 0; a < 3; ++a)
    for (int i = 0; i < scene.specimen.grid.nodes()[a]; ++i)
      place[a].push_back(i * scene.specimen.grid.spacing()[a]);
  FixedMask mask(std::size_t(scene.specimen.grid.n_nodes()));
  for (std::size_t node = 0; node < mask.n_nodes(); ++node)
    mask.fix(node, fixed);
  return std::make_unique<BoxLevel>(scene.object_stiffness(0), place, unit, mask);
}

Displacement random_field(const Grid& grid, unsigned seed) {
  std::mt19937 random(seed);
  Displacement u(grid);
  for (double& value : u.values()) // what float32 holds, for both
    value = double(float(std::uniform_real_distribution<double>(-1, 1)(random)));
  return u;
}

void put(const Displacement& u, const BoxLevel& level, float* field) {
  const BoxOperator& A = level.A();
  std::size_t i = 0;
  for (int z = 0; z < A.nodes[2]; ++z)
    for (int y = 0; y < A.nodes[1]; ++y)
      for (int x = 0; x < A.nodes[0]; ++x, ++i)
        for (int c = 0; c < 3; ++c)
          field[level.offset(c, x, y, z)] = float(u(c, i));
}

std::vector<double> scratch_for(const BoxLevel& level) {
  return std::vector<double>(std::size_t(box_scratch_bytes(level.A())) / sizeof(double) + 8);
}
void* aligned(std::vector<double>& scratch) {
  void* start = scratch.data();
  std::size_t space = scratch.size() * sizeof(double);
  return std::align(64, 8, start, space);
}

/// A u in float64, dense.
Displacement forces_of(const BoxLevel& level, const Displacement& u) {
  const BoxOperator& A = level.A();
  const std::size_t in_plane = std::size_t(A.nodes[0]) * std::size_t(A.nodes[1]);
  Displacement forces = u;
  std::vector<double> plane(3 * in_plane), scratch = scratch_for(level);
  for (int z = 0; z < A.nodes[2]; ++z) {
    apply_box(A, z, u.values().data(), plane.data(), aligned(scratch));
    for (std::size_t c = 0; c < 3; ++c)
      std::copy_n(plane.begin() + static_cast<std::ptrdiff_t>(c * in_plane), in_plane,
                  forces.component(c).begin() + static_cast<std::ptrdiff_t>(in_plane) * z);
  }
  return forces;
}

const std::vector<Index3> sizes{{1, 1, 1},  {2, 3, 1},  {7, 12, 33}, {15, 4, 3},
                                {16, 2, 5}, {47, 5, 2}, {34, 6, 4}};

TEST(BoxKernelOracle, ForcesAreThoseOfTheOperatorOfAnyBody) {
  for (const std::int64_t target : test::vector_targets())
    for (const Matter matter : {Matter::isotropic, Matter::aligned, Matter::turned})
      for (const Index3& cells : sizes) {
        const test::ForcedVectors forced(target);
        const Scene scene = box_of(matter, cells, {1e-3, 1.4e-3, 0.7e-3});
        const double unit = 25;
        const auto level = level_of(scene, unit);
        const Displacement u = random_field(scene.specimen.grid, 7);
        Displacement expected(scene.specimen.grid);
        ThreadTeam team(1);
        LatticeElasticity(scene).apply(u, expected, team); // the oracle
        const double size = test::largest(expected);
        const Displacement found = forces_of(*level, u);
        std::vector<double> scratch = scratch_for(*level);
        put(u, *level, level->u.data());
        double dot = 0;
        for (int z = 0; z < level->A().nodes[2]; ++z)
          dot += apply_box_and_dot(level->A(), z, level->u.data(), level->r.data(), aligned(scratch));
        EXPECT_NEAR(unit * dot, test::product(u, expected), 1e-5 * test::product(u, expected));
        for (int c = 0; c < 3; ++c)
          for (std::int64_t node = 0; node < scene.specimen.grid.n_nodes(); ++node) {
            const Index3 at = scene.specimen.grid.node_at(node);
            ASSERT_NEAR(unit * found(c, node), expected(c, node), 1e-13 * size) << c << ' ' << node;
            const float single = level->r.data()[level->offset(c, at[0], at[1], at[2])];
            ASSERT_NEAR(unit * double{single}, expected(c, node), 2e-6 * size) << c << ' ' << node;
          }
      }
}

TEST(BoxKernelAnalytic, CoarserLevelsAreSymmetric) {
  for (const Matter matter : {Matter::isotropic, Matter::turned}) {
    const Scene scene = box_of(matter, {11, 7, 13}, {1e-3, 1.1e-3, 0.9e-3}); // every axis ends irregularly
    const auto fine = level_of(scene, 20);
    const auto level = fine->coarser();
    const Grid grid(3, {level->A().nodes[0] - 1, level->A().nodes[1] - 1, level->A().nodes[2] - 1},
                    {1, 1, 1});
    const Displacement u = random_field(grid, 1), v = random_field(grid, 2);
    const Displacement of_u = forces_of(*level, u), of_v = forces_of(*level, v);
    EXPECT_NEAR(test::product(v, of_u), test::product(u, of_v), 1e-13 * test::product(u, of_u));
    for (int c = 0; c < 3; ++c)
      for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
        const Index3 at = grid.node_at(node);
        Displacement unit(grid);
        unit(c, node) = 1;
        const float inverse = level->A().inverse[c][at[1] + level->A().nodes[1] * at[2]][at[0]];
        ASSERT_NEAR(double{inverse} * forces_of(*level, unit)(c, node), 1, 1e-6);
      }
    const auto& t = fine->transfer();
    Displacement turn(grid); // about (1, 2, 3)
    for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
      double x[3];
      for (std::size_t a = 0; a < 3; ++a)
        x[a] = t[a].coarse_place()[std::size_t(grid.node_at(node)[a])];
      turn(0, node) = 2 * x[2] - 3 * x[1];
      turn(1, node) = 3 * x[0] - 1 * x[2];
      turn(2, node) = 1 * x[1] - 2 * x[0];
    }
    EXPECT_LE(test::largest(forces_of(*level, turn)), 1e-13 * test::largest(turn));
  }
}

TEST(BoxKernelContract, VectorsOfAnyLengthGiveTheSameBits) {
  // Among machines that fuse products with sums: that is another rounding.
  std::vector<std::vector<float>> found;
  for (const std::int64_t target : test::vector_targets()) {
    if ((target & (HWY_AVX3_DL | HWY_AVX3 | HWY_AVX2)) == 0)
      continue;
    const test::ForcedVectors forced(target);
    const Scene scene = box_of(Matter::turned, {34, 6, 4}, {1e-3, 1.4e-3, 0.7e-3});
    const auto level = level_of(scene, 25);
    put(random_field(scene.specimen.grid, 7), *level, level->u.data());
    std::vector<double> scratch = scratch_for(*level);
    for (int z = 0; z < level->A().nodes[2]; ++z)
      apply_box_and_dot(level->A(), z, level->u.data(), level->r.data(), aligned(scratch));
    found.emplace_back(level->r.data(), level->r.data() + level->field_size());
    EXPECT_EQ(found.back(), found.front());
  }
}

TEST(BoxKernelAnalytic, NoEigenvalueIsAboveTheBound) {
  const Scene scene = box_of(Matter::isotropic, {6, 5, 7}, {1e-3, 1.2e-3, 1e-3});
  const auto level = level_of(scene, 20);
  const Grid& grid = scene.specimen.grid;
  Displacement u = random_field(grid, 5);
  double found = 0;
  for (int step = 0; step < 200; ++step) { // of vectors
    const Displacement forces = forces_of(*level, u);
    found = 0;
    for (int c = 0; c < 3; ++c)
      for (std::int64_t node = 0; node < grid.n_nodes(); ++node) {
        const Index3 at = grid.node_at(node);
        u(c, node) = double{level->A().inverse[c][at[1] + grid.nodes()[1] * at[2]][at[0]]} * forces(c, node);
        found = std::max(found, std::abs(u(c, node)));
      }
    for (double& value : u.values())
      value /= found;
  }
  EXPECT_LE(found, level->largest_eigenvalue() * (1 + 1e-6));
  EXPECT_GE(found, 0.85 * level->largest_eigenvalue());
}

/// The loops over coarser levels of bodies of any shape against the obvious ones.

constexpr std::int32_t n_rows = 52;

/// Rows of 0 to 33 blocks: all that is left over by loops that take several at once.
BlockMatrix random_matrix(std::mt19937& random) {
  BlockMatrix A;
  A.first.push_back(0);
  for (std::int32_t row = 0; row < n_rows; ++row) {
    for (std::int32_t i = 0; i < row % 34; ++i)
      A.column.push_back((row + i) % n_rows);
    A.first.push_back(static_cast<std::int32_t>(A.column.size()));
  }
  A.blocks = AlignedArray<float>(9 * A.column.size() + 16);
  std::uniform_real_distribution<float> value(-1, 1);
  for (std::size_t i = 0; i < 9 * A.column.size(); ++i)
    A.blocks[i] = value(random);
  return A;
}

Weights random_weights(std::mt19937& random, std::int32_t rows) {
  Weights P;
  P.first.push_back(0);
  std::uniform_real_distribution<float> value(0, 1);
  for (std::int32_t row = 0; row < rows; ++row) {
    for (std::int32_t i = 0; i < (row / 5) % 4 * 2; ++i) { // some rows, and some groups of rows, have none
      P.column.push_back((7 * row + i) % n_rows);
      P.weight.push_back(value(random));
    }
    P.first.push_back(static_cast<std::int32_t>(P.column.size()));
  }
  return P;
}

std::vector<float> random_field(std::mt19937& random, std::size_t size) {
  std::uniform_real_distribution<float> value(-1, 1);
  std::vector<float> field(size);
  for (float& entry : field)
    entry = value(random);
  return field;
}

/// Component c of row `row` of A u, in float64.
double product(const BlockMatrix& A, std::int32_t row, std::size_t c, const std::vector<float>& u) {
  double sum = 0;
  for (auto i = std::size_t(A.first[std::size_t(row)]); i < std::size_t(A.first[std::size_t(row) + 1]); ++i)
    for (std::size_t b = 0; b < 3; ++b)
      sum += double{A.blocks[9 * i + 3 * b + c]} * double{u[block_stride * std::size_t(A.column[i]) + b]};
  return sum;
}

double interpolated(const Weights& P, std::int32_t row, std::size_t c, const std::vector<float>& u) {
  double sum = 0;
  for (auto i = std::size_t(P.first[std::size_t(row)]); i < std::size_t(P.first[std::size_t(row) + 1]); ++i)
    sum += double{P.weight[i]} * double{u[block_stride * std::size_t(P.column[i]) + c]};
  return sum;
}

/// Of sums of up to 99 products of numbers below 1; found: below 2e-6.
constexpr double rounding = 1e-5;

TEST(BlockKernelOracle, ProductsResidualsAndStepsAreThoseOfPlainLoops) {
  constexpr unsigned seed = 5;
  std::mt19937 random(seed);
  const BlockMatrix A = random_matrix(random);
  constexpr std::size_t size = block_stride * n_rows;
  const auto u = random_field(random, size), f = random_field(random, size),
             inverse = random_field(random, size);
  constexpr float weight = 0.7F;
  for (const std::int64_t target : test::vector_targets()) {
    SCOPED_TRACE(target);
    const test::ForcedVectors forced(target);
    std::vector<float> forces(size), residual(size), next(size);
    apply_blocks(A, 0, n_rows, u.data(), forces.data());
    find_block_residual(A, 0, n_rows, f.data(), u.data(), residual.data());
    relax_blocks(A, 0, n_rows, weight, inverse.data(), f.data(), u.data(), next.data());
    for (std::int32_t row = 0; row < n_rows; ++row)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t i = block_stride * std::size_t(row) + c;
        const double force = product(A, row, c, u);
        EXPECT_NEAR(double{forces[i]}, force, rounding);
        EXPECT_NEAR(double{residual[i]}, double{f[i]} - force, rounding);
        EXPECT_NEAR(double{next[i]},
                    double{u[i]} + double{weight} * double{inverse[i]} * (double{f[i]} - force), rounding);
      }
  }
}

/// Rows differ by 1e30 in size, and numbers of a row by 1e6.
TEST(BlockKernelOracle, ProductsOfRoundedBlocks) {
  constexpr unsigned seed = 8;
  std::mt19937 random(seed);
  BlockMatrix A = random_matrix(random);
  for (std::size_t row = 0; row < n_rows; ++row)
    for (auto i = std::size_t(A.first[row]); i < std::size_t(A.first[row + 1]); ++i)
      for (std::size_t e = 0; e < 9; ++e)
        A.blocks[9 * i + e] *= (row % 2 == 0 ? 1e-15F : 1e15F) * (i % 3 == 0 ? 1e-6F : 1);
  const auto rows = A.first, columns = A.column;
  ThreadTeam team(2);
  const RoundedBlockMatrix B = rounded(A, team);
  A.first = rows;
  A.column = columns;
  constexpr std::size_t size = block_stride * n_rows;
  const auto u = random_field(random, size), f = random_field(random, size),
             inverse = random_field(random, size);
  constexpr float weight = 0.7F;
  std::vector<float> first;
  for (const std::int64_t target : test::vector_targets()) {
    SCOPED_TRACE(target);
    const test::ForcedVectors forced(target);
    std::vector<float> forces(size), residual(size), next(size);
    apply_blocks(B, 0, n_rows, u.data(), forces.data());
    find_block_residual(B, 0, n_rows, f.data(), u.data(), residual.data());
    relax_blocks(B, 0, n_rows, weight, inverse.data(), f.data(), u.data(), next.data());
    for (std::int32_t row = 0; row < n_rows; ++row)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t i = block_stride * std::size_t(row) + c;
        double terms = 0; // at their largest
        for (auto k = std::size_t(A.first[std::size_t(row)]); k < std::size_t(A.first[std::size_t(row) + 1]);
             ++k)
          for (std::size_t b = 0; b < 3; ++b)
            terms += std::abs(double{A.blocks[9 * k + 3 * b + c]} *
                              double{u[block_stride * std::size_t(A.column[k]) + b]});
        const double near = terms / 2048 + 1e-6 * terms, force = double{forces[i]};
        EXPECT_NEAR(force, product(A, row, c, u), near);
        EXPECT_NEAR(double{residual[i]}, double{f[i]} - force, 1e-6 * (terms + 1));
        EXPECT_NEAR(double{next[i]},
                    double{u[i]} + double{weight} * double{inverse[i]} * (double{f[i]} - force),
                    1e-6 * (terms + 2));
      }
    for (std::size_t i = 3; i < forces.size(); i += block_stride)
      forces[i] = 0;                                         // does not count
    if ((target & (HWY_AVX3_DL | HWY_AVX3 | HWY_AVX2)) == 0) // which fuse products with sums
      continue;
    if (first.empty())
      first = forces;
    EXPECT_EQ(forces, first);
  }
}

TEST(BlockKernelOracle, InterpolationIsThatOfPlainLoops) {
  constexpr unsigned seed = 6;
  std::mt19937 random(seed);
  constexpr std::int32_t rows = 72;
  const Weights P = random_weights(random, rows);
  const auto u = random_field(random, block_stride * n_rows);
  const auto before = random_field(random, block_stride * rows);
  for (const std::int64_t target : test::vector_targets()) {
    SCOPED_TRACE(target);
    const test::ForcedVectors forced(target);
    auto out = before;
    std::vector<float> alone(block_stride * rows);
    interpolate_blocks(P, 0, rows, u.data(), true, out.data());
    interpolate_blocks(P, 0, rows, u.data(), false, alone.data());
    for (std::int32_t row = 0; row < rows; ++row)
      for (std::size_t c = 0; c < 3; ++c) {
        const std::size_t i = block_stride * std::size_t(row) + c;
        const double sum = interpolated(P, row, c, u);
        EXPECT_NEAR(double{alone[i]}, sum, rounding);
        EXPECT_NEAR(double{out[i]}, double{before[i]} + sum, rounding);
      }
  }
}

/// Murmur's finaliser of an entry's number: its last bit is the sign.
float eigenvalue_noise(std::size_t i, float inverse) {
  auto mixed = static_cast<std::uint32_t>(i) + 1;
  mixed = (mixed ^ mixed >> 16) * 0x85ebca6bu;
  mixed = (mixed ^ mixed >> 13) * 0xc2b2ae35u;
  const float sign = (mixed ^ mixed >> 16) & 1 ? 1.0f : -1.0f;
  return inverse > 0 ? sign / std::sqrt(inverse) : 0;
}

TEST(BlockKernelOracle, NoiseIsThatOfOneEntryAfterAnother) {
  constexpr unsigned seed = 8;
  std::mt19937 random(seed);
  constexpr std::size_t first = 4096, size = 160;
  const auto inverse = random_field(random, size); // half of it below 0: as if fixed
  for (const std::int64_t target : test::vector_targets()) {
    SCOPED_TRACE(target);
    const test::ForcedVectors forced(target);
    std::vector<float> noise(size);
    noise_entries(size, first, inverse.data(), noise.data());
    for (std::size_t i = 0; i < size; ++i)
      EXPECT_EQ(noise[i], eigenvalue_noise(first + i, inverse[i])) << i;
  }
}

/// Machines that fuse products with sums, whatever the length of their vectors.
TEST(BlockKernelContract, VectorsOfAnyLengthGiveTheSameBits) {
  constexpr unsigned seed = 7;
  std::mt19937 random(seed);
  const BlockMatrix A = random_matrix(random);
  const auto u = random_field(random, block_stride * n_rows);
  std::vector<float> first;
  for (const std::int64_t target : test::vector_targets()) {
    if ((target & (HWY_AVX3_DL | HWY_AVX3 | HWY_AVX2)) == 0)
      continue;
    const test::ForcedVectors forced(target);
    std::vector<float> forces(block_stride * n_rows);
    apply_blocks(A, 0, n_rows, u.data(), forces.data());
    for (std::size_t i = 3; i < forces.size(); i += block_stride)
      forces[i] = 0; // does not count
    if (first.empty())
      first = forces;
    EXPECT_EQ(forces, first) << target;
  }
}

} // namespace
} // namespace maille::deform
