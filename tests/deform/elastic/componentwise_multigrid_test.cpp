#include "elastic/componentwise/axis_coarsening.hpp"
#include "elastic/componentwise/componentwise_multigrid.hpp"
#include "elastic/componentwise/componentwise_solver.hpp"
#include "lattice/field_memory.hpp"
#include "maille/base/arena.hpp"
#include "support/bodies/holed_bodies.hpp"
#include "support/componentwise_oracle.hpp"
#include "support/fields.hpp"
#include "support/kit.hpp"
#include "support/vector_targets.hpp"

#include <Eigen/Eigenvalues>
#include <cstring>

namespace maille::deform {
namespace {

using test::Dice;
using test::even_limits;
using test::face;
using test::lattice_box;

std::vector<double> first_numbers(int n) {
  std::vector<double> places(static_cast<std::size_t>(n));
  std::iota(places.begin(), places.end(), 0.0);
  return places;
}

TEST(AxisCoarseningAnalytic, KeepsLinearFieldsMassAndTheirEnergy) {
  std::vector<double> place, link, mass;
  for (const int n : {2, 3, 4, 5, 8, 13, 100}) {
    place = first_numbers(n);
    link.assign(std::size_t(n - 1), 1); // unit stiffness per unit length
    mass.assign(std::size_t(n), 1);
    while (place.size() > 2) {
      const AxisCoarsening axis(place, true);
      EXPECT_EQ(axis.n_coarse(), (int(place.size()) - 1) / 2 + 1);
      EXPECT_EQ(axis.coarse_place().back(), place.back());
      for (int i = 0; i < axis.n_fine(); ++i) { // x is interpolated exactly
        const auto k = std::size_t(axis.left(i));
        const double t = axis.right_weight(i);
        const double next = t > 0 ? axis.coarse_place()[k + 1] : 0;
        EXPECT_NEAR((1 - t) * axis.coarse_place()[k] + t * next, place[std::size_t(i)], 1e-5);
      }
      link = axis.coarse_link(link);
      mass = axis.coarse_mass(mass);
      place = axis.coarse_place();
      double energy = 0;
      for (std::size_t i = 0; i < link.size(); ++i) {
        EXPECT_LT((place[i + 1] - place[i]) / (place[1] - place[0]), 2.0001);
        energy += link[i] * (place[i + 1] - place[i]) * (place[i + 1] - place[i]);
      }
      EXPECT_NEAR(energy, n - 1, 1e-5 * n); // of u = x: its length
      EXPECT_NEAR(std::accumulate(mass.begin(), mass.end(), 0.0), n, 1e-5 * n);
    }
  }
}

/// One component of a scene as the solver sees it, and the same dense.
struct Pair {
  Scene scene;
  CellModuli moduli;
  ThreadTeam team{1};
  test::QuadraticProgram dense;
  ComponentwiseSolver solver;

  Pair(Scene s, int component)
      : scene(std::move(s)), moduli(scene), dense(test::dense_problem(scene, scene.prescribed, component)),
        solver(scene, moduli, component, fixed(scene, component), team) {}

  static List<FixedNode> fixed(const Scene& scene, int component) {
    List<FixedNode> list;
    for (const Prescribed& p : scene.prescribed)
      if (p.component == component)
        list.push_back({p.node, p.value});
    return list;
  }
  /// B A, dense, over the free nodes.
  Eigen::MatrixXd preconditioned() {
    ComponentwiseLevel& finest = solver.multigrid().finest();
    const auto n = static_cast<Eigen::Index>(dense.unknowns.size());
    Eigen::MatrixXd B(n, n);
    for (Eigen::Index j = 0; j < n; ++j) {
      finest.clear(finest.f);
      finest.f.data()[finest.offset(finest.node_at(dense.unknowns[std::size_t(j)].second))] = 1;
      solver.multigrid().precondition();
      for (Eigen::Index i = 0; i < n; ++i)
        B(i, j) =
            double{finest.u.data()[finest.offset(finest.node_at(dense.unknowns[std::size_t(i)].second))]};
    }
    return B / solver.unit();
  }
};

/// Smallest and largest eigenvalue of B A, B made symmetric; and how far it was from that.
struct Spectrum {
  double smallest = 0, largest = 0, asymmetry = 0;
};

Spectrum spectrum_of(Pair& pair) {
  const Eigen::MatrixXd B = pair.preconditioned();
  const Eigen::MatrixXd L = pair.dense.K.llt().matrixL();
  const Eigen::MatrixXd symmetric = L.transpose() * (0.5 * (B + B.transpose())) * L;
  const Eigen::VectorXd values = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric).eigenvalues();
  return {values(0), values(values.size() - 1), (B - B.transpose()).norm() / B.norm()};
}

Scene patch_scene(const Index3& cells, double fibre_ratio) {
  Scene scene = lattice_box({cells[0], cells[1], cells[2]}, even_limits(2, 0, 2));
  scene.materials[0].elasticity =
      ElasticConstants::transversely_isotropic(fibre_ratio * 1e4, 1e4, 4e3, 0.3, 0.3);
  for (const Index3& at : face(scene, 2, false))
    test::hold(scene, at);
  for (const Index3& at : face(scene, 2, true)) // a patch whose edges no coarse grid meets
    if (at[0] >= 3 && at[0] <= 7 && at[1] == 5)
      test::move(scene, at, {1, 1, 1});
  return scene;
}

TEST(ComponentwiseMultigridContract, OneCycleIsSymmetricAndCloseToTheInverse) {
  // Eigenvalues of B A near 1: above 1 where coarse links are too soft, which anchors and lumped sums keep
  // from happening; the lower end is what conjugate gradients pay for.
  for (const double fibre_ratio : {1.0, 50.0, 1000.0})
    for (const Index3& cells : {Index3{12, 9, 6}, Index3{11, 10, 5}, Index3{16, 8, 4}}) {
      if (test::is_sanitized && cells[1] != 8)
        continue;
      Pair pair(patch_scene(cells, fibre_ratio), 0);
      const Spectrum spectrum = spectrum_of(pair);
      EXPECT_LE(spectrum.asymmetry, 1e-5);
      EXPECT_GT(spectrum.smallest, 0.3) << fibre_ratio << " " << cells[0];
      EXPECT_LT(spectrum.largest, 1.2) << fibre_ratio << " " << cells[0];
    }
}

TEST(ComponentwiseMultigridContract, OneCycleStaysPositiveOnHoledBodies) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    Pair pair(test::holed_body(random), 0);
    if (pair.dense.unknowns.empty() || pair.dense.unknowns.size() > 500)
      continue;
    const Spectrum spectrum = spectrum_of(pair);
    EXPECT_LE(spectrum.asymmetry, 1e-4) << "seed " << seed;
    EXPECT_GT(spectrum.smallest, 0) << "seed " << seed;
    EXPECT_LT(spectrum.largest, 2) << "seed " << seed;
  }
}

TEST(ComponentwiseMultigridOracle, EveryKindOfVectorSolvesTheDenseProblem) {
  for (const std::int64_t target : test::vector_targets()) {
    const test::ForcedVectors forced(target);
    for (const double fibre_ratio : {1.0, 50.0}) {
      Pair pair(patch_scene({13, 9, 6}, fibre_ratio), 1);
      std::vector<double> u(std::size_t(pair.scene.specimen.grid.n_nodes()));
      pair.solver.solve(u, {}, 1e-10, false, {});
      EXPECT_LE(test::largest_difference(u, pair.dense.elastic().component(1)), 1e-9);
    }
  }
}

// Truth: what the header promises of sizes below and above those that are mapped.
TEST(FieldMemoryContract, IsZeroAlignedAndExclusive) {
  struct Field {
    unsigned char* data;
    std::size_t size;
  };
  for (int round = 0; round < 3; ++round) { // what was written before is gone
    std::vector<Field> fields;
    Charge charge;
    for (const std::size_t size :
         {1, 100, 16384, 16385, 700000, 700001, 900000, 1572863, 1572864, 2097152, 2200000, 4056128, 6291457})
      for (int copy = 0; copy < 3; ++copy)
        fields.push_back({static_cast<unsigned char*>(allocate_zeroed(size, charge)), size});
    for (std::size_t i = 0; i < fields.size(); ++i) {
      ASSERT_EQ(reinterpret_cast<std::uintptr_t>(fields[i].data) % 64, 0u);
      for (std::size_t k = 0; k < fields[i].size; ++k)
        ASSERT_EQ(fields[i].data[k], 0) << fields[i].size << ' ' << k;
      std::memset(fields[i].data, int(i) + 1, fields[i].size);
    }
    for (std::size_t i = 0; i < fields.size(); ++i)
      for (std::size_t k = 0; k < fields[i].size; ++k)
        ASSERT_EQ(fields[i].data[k], i + 1);
    for (std::size_t i = 0; i < fields.size(); i += 2) // in another order than they came
      release_zeroed(fields[i].data, fields[i].size);
    for (std::size_t i = 1; i < fields.size(); i += 2)
      release_zeroed(fields[i].data, fields[i].size);
  }
  release_zeroed(nullptr, 5000000);
}

// Truth: what arena.hpp promises of sizes below, in and above those of one region.
TEST(ArrayMemoryContract, ArraysAreAlignedAndExclusive) {
  struct Array {
    unsigned char* data;
    std::size_t size;
    unsigned char mark;
  };
  std::mt19937 random(7); // any
  std::vector<Array> arrays;
  const auto release = [&](std::size_t i) {
    const Array array = arrays[i];
    for (std::size_t k = 0; k < array.size; k += 61)
      ASSERT_EQ(array.data[k], array.mark) << array.size << ' ' << k;
    ASSERT_EQ(array.data[array.size - 1], array.mark);
    release_array(array.data, array.size, 64);
    arrays.erase(arrays.begin() + static_cast<std::ptrdiff_t>(i));
  };
  const std::size_t sizes[] = {1, 65535, 65536, 65537, 100000, 1 << 20, 3000001, 20 << 20, (32 << 20) + 1};
  for (int step = 0; step < 400; ++step) {
    if (arrays.size() < 12 && random() % 3 != 0) {
      const std::size_t size = sizes[random() % std::size(sizes)];
      const auto mark = static_cast<unsigned char>(random() % 251 + 1);
      auto* const data = static_cast<unsigned char*>(allocate_array(size, 64));
      ASSERT_EQ(reinterpret_cast<std::uintptr_t>(data) % 64, 0u);
      std::memset(data, mark, size);
      arrays.push_back({data, size, mark});
    } else if (!arrays.empty())
      release(random() % arrays.size());
  }
  while (!arrays.empty())
    release(0);
}

#if defined(__linux__) && !defined(__SANITIZE_ADDRESS__) // with which arrays are the heap's
TEST(ArrayMemoryContract, WhatIsGivenBackIsThereForTheNextOne) {
  void* const kept = allocate_array(1 << 17, 64);
  void* const first = allocate_array(1 << 20, 64);
  release_array(first, 1 << 20, 64);
  EXPECT_EQ(allocate_array(1 << 20, 64), first);
  release_array(first, 1 << 20, 64);
  release_array(kept, 1 << 17, 64);
}
#endif

} // namespace
} // namespace maille::deform
