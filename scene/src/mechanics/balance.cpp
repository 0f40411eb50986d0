// Balance of the forces on a body, and cases in which forces are meaningless.
#include "maille/scene/mechanics/mechanics.hpp"
#include "mechanics/face_force.hpp"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace maille {

namespace {

Eigen::Vector3d of(const Vec3& v) {
  return {v[0], v[1], v[2]};
}

/// Sum of forces, and of their moments about a place.
struct Sum {
  Eigen::Vector3d force = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
  void add(const std::vector<Resultant>& list, const Eigen::Vector3d& about) {
    for (const Resultant& one : list) {
      force += of(one.force);
      moment += of(one.moment) + (of(one.centroid) - about).cross(of(one.force));
    }
  }
};

double diagonal_of(const Grid& grid) {
  Eigen::Vector3d size = Eigen::Vector3d::Zero();
  for (int a = 0; a < grid.dimension(); ++a)
    size[a] = grid.cells()[a] * grid.spacing()[a];
  return size.norm();
}

ForceCheck balance_of(const Scene& scene, const Answer& answer, const Mechanics& found) {
  // Imbalance below `tolerance` (of the largest force, or force times size) is solver error; moments below
  // `rounding` of that, and forces below `rounding` of the sum over nodes, are rounding error.
  const double tolerance = std::max(1e-3, 10 * scene.relaxation.tolerance), rounding = 1e-9;
  double largest = 0;
  for (const auto* list : {&found.holds, &found.moves, &found.loads})
    for (const Resultant& one : *list)
      largest = std::max(largest, of(one.force).norm());
  const Grid& grid = scene.specimen.grid;
  double contraction = 0; // self-balanced: stress times mean cross-section
  for (const double stress : scene.active_stress)
    contraction += std::abs(stress) / diagonal_of(grid);
  for (int a = 0; a < grid.dimension(); ++a)
    contraction *= grid.spacing()[a];
  double applied = 0; // sum of sizes, because a uniform pressure has no resultant
  for (const FaceLoad& load : scene.tractions)
    applied += of(force_on_face(scene, answer, load)).norm();
  largest = std::max({largest, contraction, applied});
  const auto& middles = found.holds.empty() ? found.moves : found.holds;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Resultant& one : middles)
    middle += of(one.centroid) / static_cast<double>(middles.size());
  Sum held, moved, loaded;
  held.add(found.holds, middle);
  moved.add(found.moves, middle);
  loaded.add(found.loads, middle);
  const Eigen::Vector3d force = -(held.force + moved.force + loaded.force),
                        moment = -(held.moment + moved.moment + loaded.moment);
  const double of_size = largest * diagonal_of(grid);
  ForceCheck check;
  check.missing = {"missing",
                   "",
                   {middle[0], middle[1], middle[2]},
                   {force[0], force[1], force[2]},
                   {moment[0], moment[1], moment[2]}};
  if (largest == 0)
    return check;
  check.force_share = force.norm() / largest;
  check.moment_share = moment.norm() / std::max({held.moment.norm(), moved.moment.norm(),
                                                 loaded.moment.norm(), rounding * of_size});
  double on_nodes = 0;
  for (const double reaction : answer.reaction)
    on_nodes += std::abs(reaction);
  if (check.force_share > tolerance && force.norm() > rounding * on_nodes)
    check.caveats.push_back(
        fmt::format("forces are not in balance: {:.3g} N is missing, {:.3g} % of the largest", force.norm(),
                    100 * check.force_share));
  if (moment.norm() > tolerance * of_size)
    check.caveats.push_back(fmt::format("moments are not in balance: {:.3g} N m is missing, {:.3g} % of the "
                                        "moment about the {}",
                                        moment.norm(), 100 * check.moment_share,
                                        found.holds.empty() ? "moves" : "holds"));
  return check;
}

} // namespace

std::optional<ForceCheck> check_forces(const Scene& scene, const Answer& answer) {
  const Mechanics found = resultants_of(scene, answer);
  if (found.holds.empty() && found.moves.empty())
    return std::nullopt;
  ForceCheck check = balance_of(scene, answer, found);
  if (answer.method == "relaxed") {
    if (!check.caveats.empty())
      check.caveats.back() += ": its components know nothing of each other";
    if (const double factor = stiffening_of_relaxed(scene); factor > 1 + 1e-9)
      check.caveats.push_back(fmt::format("forces and stress are of matter up to {:.3g} times as stiff{}",
                                          factor,
                                          has_modulus(scene, answer) ? "" : ", and mean nothing here"));
  } else if (!check.caveats.empty() && scene.limits_bind_coupled() && !in_blocks(scene))
    check.caveats.back() += ": limits act along each of the object's axes, and hold it against turning";
  const bool uses_slack_up = answer.method == "relaxed" && scene.limits.from == LimitSource::taut &&
                             !scene.limits.taut_scale && !found.moves.empty();
  if (answer.n_cut > 0 || uses_slack_up)
    check.caveats.push_back(fmt::format(
        "{}: taut links carry any force, and these forces are one set of many in balance",
        answer.n_cut > 0 ? "limits cut the moves back" : "the moves use the slack of taut limits up"));
  if (has_load_beside_test(scene))
    check.caveats.push_back("stiffness and modulus of the [test] are of the material and the loads together");
  return check;
}

bool has_load_beside_test(const Scene& scene) {
  return scene.test && (scene.has_loads() || !scene.springs.empty());
}

double stiffening_of_relaxed(const Scene& scene) {
  double largest = 1;
  for (const Material& material : scene.materials)
    for (int a = 0; a < 3 && scene.dimension() > 1; ++a) {
      const auto axis = static_cast<std::size_t>(a);
      largest = std::max(largest, stiffness(material.elasticity)(a, a) * material.relaxed_weights[axis] /
                                      material.elasticity.youngs_modulus[axis]);
    }
  return largest;
}

bool has_modulus(const Scene& scene, const Answer& answer) {
  return answer.n_cut == 0 &&
         (answer.method != "relaxed" || stiffening_of_relaxed(scene) <= largest_stiffening);
}

} // namespace maille
