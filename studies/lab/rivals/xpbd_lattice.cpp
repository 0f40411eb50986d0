#include "maille/scene/scene.hpp"
#include "rivals/lattice_rivals.hpp"
#include "rivals/spring_lattice.hpp"
#include "rivals/xpbd_kernel.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

namespace maille::lab {

namespace {

using Clock = std::chrono::steady_clock;
using Field = std::array<std::vector<float>, 3>;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// A body on its way to rest: the arrays that XpbdState points to.
class XpbdBody {
public:
  XpbdBody(const Scene& scene, const SpringLattice& lattice) : unit_(lattice.unit_of_length()) {
    const Grid& grid = scene.specimen.grid;
    const auto n = static_cast<std::size_t>(grid.n_nodes());
    std::ranges::copy(grid.nodes(), state_.nodes);
    for (std::size_t b = 0; b < 3; ++b) {
      for (Field* field : {&u_, &before_, &start_, &inverse_mass_})
        (*field)[b].assign(n, 0);
      state_.u[b] = u_[b].data();
      state_.before[b] = before_[b].data();
      state_.start[b] = start_[b].data();
      state_.inverse_mass[b] = inverse_mass_[b].data();
    }
    prepare_nodes(scene, lattice);
    prepare_directions(lattice, n);
    start();
    // What moves at once put in, as motion of the lightest node. Loads go on putting energy in: how much is
    // not known beforehand.
    float lightest = 0;
    for (const auto& component : inverse_mass_)
      lightest = std::max(lightest, *std::ranges::max_element(component));
    const double energy = lattice.strain_energy(displacement(grid)) /
                          (lattice.unit_of_stiffness() * lattice.unit_of_length() * lattice.unit_of_length());
    most_motion_ =
        scene.has_loads() ? std::numeric_limits<double>::max() : 2 * energy * static_cast<double>(lightest);
  }
  XpbdBody(const XpbdBody&) = delete;
  XpbdBody& operator=(const XpbdBody&) = delete;

  /// One time step of one iteration.
  void step() {
    // A push of the multipliers costs nearly an iteration. The last one can be had again for nothing; it lags
    // only by how far constraints have turned since.
    const bool push_afresh = n_steps_++ % 8 == 0;
    const auto k = static_cast<float>(since_stop_);
    xpbd_coast(state_, k / (k + 3), !push_afresh);
    if (push_afresh)
      xpbd_push(state_);
    is_backward_ = !is_backward_;
    xpbd_solve(state_, is_backward_);
    const XpbdProgress progress = xpbd_progress(state_);
    // Nothing can move faster than all the energy that the moves put in makes it. Written so that NaN fails
    // too.
    if (!(progress.motion <= most_motion_)) {
      make_heavier();
      start();
    } else if (since_stop_ > 4 && progress.climb > 0) {
      // The first steps after a stop build the velocity up; to judge them would stop it for ever.
      stop(progress.motion);
    } else {
      ++since_stop_;
    }
  }

  bool is_finite() const {
    return std::ranges::all_of(u_, [](const std::vector<float>& component) {
      return std::ranges::all_of(component, [](float x) { return std::isfinite(x); });
    });
  }

  Displacement displacement(const Grid& grid) const {
    Displacement out(grid);
    for (std::size_t b = 0; b < out.n_components(); ++b)
      std::ranges::transform(u_[b], out.component(b).begin(), [&](float x) { return double{x} * unit_; });
    return out;
  }

private:
  void prepare_nodes(const Scene& scene, const SpringLattice& lattice) {
    const std::vector<float> stiffness = lattice.stiffness_at_nodes();
    const double unit_of_force = lattice.unit_of_stiffness() * unit_;
    for (int component = 0; component < scene.dimension(); ++component) {
      const auto b = static_cast<std::size_t>(component);
      for (std::size_t i = 0; i < stiffness.size(); ++i)
        inverse_mass_[b][i] = stiffness[i] > 0 ? 2 / stiffness[i] : 0;
      for (const double force : nodal_forces(scene, component))
        load_[b].push_back(static_cast<float>(force / unit_of_force));
      state_.load[b] = load_[b].empty() ? nullptr : load_[b].data();
    }
    for (const Prescribed& p : scene.prescribed) {
      const auto b = static_cast<std::size_t>(p.component), i = static_cast<std::size_t>(p.node);
      inverse_mass_[b][i] = 0;
      moves_.push_back({b, i, static_cast<float>(p.value / unit_)});
    }
  }

  void start() {
    for (Field* field : {&u_, &before_, &start_})
      for (auto& component : *field)
        std::ranges::fill(component, 0.0F);
    for (auto& direction : multipliers_)
      std::ranges::fill(direction, 0.0F);
    for (const auto& [b, i, value] : moves_)
      u_[b][i] = before_[b][i] = start_[b][i] = value;
    n_steps_ = since_stop_ = 0;
    motion_at_stop_ = std::numeric_limits<double>::infinity();
  }

  /// Where motion does not fade from stop to stop, the stretched springs are too stiff for the masses; unless
  /// it is so little that rounding keeps it up.
  void stop(double motion) {
    if (motion > motion_at_stop_ && motion > 1e-8 * most_motion_)
      make_heavier();
    motion_at_stop_ = motion;
    since_stop_ = 0;
  }

  void make_heavier() {
    for (auto& component : inverse_mass_)
      for (float& w : component)
        w /= 2;
    most_motion_ /= 2;
    n_steps_ = 0; // the last push was one of lighter nodes
  }

  void prepare_directions(const SpringLattice& lattice, std::size_t n) {
    for (const SpringDirection& spring : lattice.directions()) {
      XpbdDirection& direction = directions_.emplace_back();
      std::ranges::copy(spring.step, direction.step);
      double length2 = 0;
      for (std::size_t b = 0; b < 3; ++b) {
        direction.rest[b] = static_cast<float>(spring.rest[b]);
        length2 += spring.rest[b] * spring.rest[b];
      }
      direction.rest_length = static_cast<float>(std::sqrt(length2));
      direction.stiffness = spring.stiffness.data();
      direction.multiplier = multipliers_.emplace_back(n, 0.0F).data();
    }
    state_.n_directions = static_cast<int>(directions_.size());
    state_.direction = directions_.data();
  }

  struct Move {
    std::size_t component, node;
    float value; ///< in units of length
  };

  double unit_; ///< of length [m]
  std::vector<Move> moves_;
  double most_motion_ = 0; ///< that energy can account for, as XpbdProgress::motion
  double motion_at_stop_ = 0;
  Field u_, before_, start_, inverse_mass_, load_;
  std::vector<std::vector<float>> multipliers_;
  std::vector<XpbdDirection> directions_;
  XpbdState state_{};
  std::int64_t n_steps_ = 0;
  int since_stop_ = 0;      ///< of the velocities
  bool is_backward_ = true; ///< so that the first iteration goes forward
};

/// @param go_on asked after every iteration, with their number and the seconds that they took
RivalResult relax(const Scene& scene, const std::function<bool(std::int64_t, double)>& go_on) {
  RivalResult result;
  const auto start = Clock::now();
  const SpringLattice lattice(scene);
  result.note = lattice.note();
  if (!lattice.refusal().empty()) {
    result.note = lattice.refusal();
    return result;
  }
  XpbdBody body(scene, lattice);
  result.seconds_of_setup = seconds_since(start);
  const auto first = Clock::now();
  do {
    body.step();
    ++result.iterations;
    result.seconds = seconds_since(first);
  } while (go_on(result.iterations, result.seconds));
  result.displacement = body.displacement(scene.specimen.grid);
  if (!body.is_finite())
    result.note = "the iteration diverged";
  result.residual = body.is_finite() ? lattice.residual(scene, result.displacement)
                                     : std::numeric_limits<double>::infinity();
  return result;
}

} // namespace

RivalResult relax_by_xpbd(const Scene& scene, double seconds_budget) {
  return relax(scene, [=](std::int64_t, double seconds) { return seconds < seconds_budget; });
}

RivalResult relax_by_xpbd_steps(const Scene& scene, std::int64_t iterations) {
  return relax(scene, [=](std::int64_t done, double) { return done < iterations; });
}

} // namespace maille::lab
