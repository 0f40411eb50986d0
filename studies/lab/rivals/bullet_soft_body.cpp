#include "rivals/lattice_rivals.hpp"
#include "rivals/spring_lattice.hpp"

#include <BulletSoftBody/btSoftBody.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <vector>

namespace maille::lab {

namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

btVector3 vector_of(const Vec3& v, double unit) {
  return {static_cast<btScalar>(v[0] / unit), static_cast<btScalar>(v[1] / unit),
          static_cast<btScalar>(v[2] / unit)};
}

/// Which nodes the scene prescribes, and where to.
struct Prescription {
  std::vector<int> components; ///< per grid node: how many are prescribed
  std::vector<Vec3> value;     ///< [m]

  explicit Prescription(const Scene& scene)
      : components(static_cast<std::size_t>(scene.specimen.grid.n_nodes()), 0),
        value(components.size(), Vec3{}) {
    for (const Prescribed& p : scene.prescribed) {
      ++components[static_cast<std::size_t>(p.node)];
      value[static_cast<std::size_t>(p.node)][static_cast<std::size_t>(p.component)] = p.value;
    }
  }
};

std::string refusal(const Scene& scene, const SpringLattice& lattice, const Prescription& prescription) {
  if (!lattice.refusal().empty())
    return lattice.refusal();
  if (scene.has_loads())
    return "Bullet's links have no modulus, so loads mean nothing to them";
  if (std::ranges::any_of(prescription.components, [&](int n) { return n != 0 && n != scene.dimension(); }))
    return "Bullet holds and moves whole nodes only";
  return "";
}

/// A btSoftBody of the lattice, in units of its length: Bullet takes lengths below 1e-7 for none.
class SoftBody {
public:
  SoftBody(const Scene& scene, const SpringLattice& lattice, const Prescription& prescription)
      : grid_(scene.specimen.grid), unit_(lattice.unit_of_length()) {
    world_.m_gravity.setZero();
    add_nodes(scene, lattice, prescription);
    add_links(lattice);
    body_->m_cfg.piterations = 10;
    body_->m_cfg.kDP = btScalar(0.1);
    // Left to its first step, Bullet would take the moved nodes' links for links at rest.
    body_->updateConstants();
    body_->m_bUpdateRtCst = false;
    for (int i = 0; i < body_->m_nodes.size(); ++i) {
      btSoftBody::Node& node = body_->m_nodes[i];
      node.m_x += vector_of(
          prescription.value[static_cast<std::size_t>(node_of_[static_cast<std::size_t>(i)])], unit_);
      node.m_q = node.m_x;
    }
  }

  void step() {
    body_->predictMotion(btScalar(1.0 / 60));
    body_->solveConstraints();
    body_->integrateMotion();
  }

  Displacement displacement() const {
    Displacement out(grid_);
    for (int i = 0; i < body_->m_nodes.size(); ++i) {
      const btVector3 u = body_->m_nodes[i].m_x - rest_[static_cast<std::size_t>(i)];
      for (int b = 0; b < grid_.dimension(); ++b)
        out(b, node_of_[static_cast<std::size_t>(i)]) = double{u[b]} * unit_;
    }
    return out;
  }

private:
  void add_nodes(const Scene& scene, const SpringLattice& lattice, const Prescription& prescription) {
    const std::vector<float> stiffness = lattice.stiffness_at_nodes();
    std::vector<btScalar> mass;
    number_.assign(stiffness.size(), -1);
    for (std::size_t i = 0; i < stiffness.size(); ++i) {
      if (stiffness[i] == 0)
        continue;
      number_[i] = static_cast<int>(rest_.size());
      node_of_.push_back(static_cast<std::int64_t>(i));
      rest_.push_back(vector_of(scene.specimen.position(grid_.node_at(node_of_.back())), unit_));
      mass.push_back(prescription.components[i] > 0 ? btScalar(0) : btScalar(1)); // 0 is held for ever
    }
    body_ = std::make_unique<btSoftBody>(&world_, static_cast<int>(rest_.size()), rest_.data(), mass.data());
  }

  void add_links(const SpringLattice& lattice) {
    std::map<float, btSoftBody::Material*> materials; // few: by how many cells share a link, and whose
    for (const SpringDirection& direction : lattice.directions())
      for (std::size_t i = 0; i < direction.stiffness.size(); ++i) {
        const float stiffness = direction.stiffness[i];
        if (stiffness == 0)
          continue;
        btSoftBody::Material*& material = materials[stiffness];
        if (!material) {
          material = body_->appendMaterial();
          material->m_kLST = stiffness;
        }
        body_->appendLink(number_[i], number_[i + static_cast<std::size_t>(direction.offset)], material);
      }
  }

  Grid grid_;
  double unit_; ///< of length [m]
  btSoftBodyWorldInfo world_;
  std::vector<int> number_;           ///< per grid node: of Bullet's, or -1
  std::vector<std::int64_t> node_of_; ///< per node of Bullet's: of the grid
  std::vector<btVector3> rest_;
  std::unique_ptr<btSoftBody> body_;
};

} // namespace

std::optional<RivalResult> relax_by_bullet(const Scene& scene, double seconds_budget) {
  RivalResult result;
  const auto start = Clock::now();
  const SpringLattice lattice(scene);
  const Prescription prescription(scene);
  result.note = refusal(scene, lattice, prescription);
  if (!result.note.empty())
    return result;
  result.note = lattice.note();
  SoftBody body(scene, lattice, prescription);
  result.seconds_of_setup = seconds_since(start);
  const auto first = Clock::now();
  do {
    body.step();
    ++result.iterations;
    result.seconds = seconds_since(first);
  } while (result.seconds < seconds_budget);
  result.displacement = body.displacement();
  if (!std::ranges::all_of(result.displacement.values(), [](double x) { return std::isfinite(x); }))
    result.note = "the iteration diverged";
  return result;
}

} // namespace maille::lab
