#include "feasible/bounds/clipping.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace maille::deform {

namespace {

double largest_value(std::span<const Prescribed> prescribed, int component) {
  double largest = 0;
  for (const Prescribed& p : prescribed)
    if (p.component == component)
      largest = std::max(largest, std::abs(p.value));
  return largest;
}

} // namespace

/// Bounds of all values of the component by the values of one kind.
void Clipper::bounds_by(Kind kind, int component, std::span<const Prescribed> prescribed, bool least_too) {
  const auto n = static_cast<std::size_t>(
      std::ranges::count_if(prescribed, [&](const Prescribed& p) { return p.component == component; }));
  ends_.clear();
  ends_.reserve(n);
  nodes_.clear();
  nodes_.reserve(n);
  for (const Prescribed& p : prescribed) {
    if (p.component != component)
      continue;
    nodes_.push_back(p.node);
    if (kind == Kind::any || p.held == (kind == Kind::hold))
      ends_.push_back({p.node, p.value});
  }
  greatest_.resize(nodes_.size());
  source_.bounds_at(Side::greatest, component, ends_, nodes_, greatest_);
  if (!least_too)
    return;
  least_.resize(nodes_.size());
  source_.bounds_at(Side::least, component, ends_, nodes_, least_);
}

/// True if all values of the component are compatible.
bool Clipper::can_all_be_met(int component, std::span<const Prescribed> prescribed, double tolerance) {
  bounds_by(Kind::any, component, prescribed, false);
  auto greatest = greatest_.cbegin();
  return std::ranges::all_of(prescribed, [&](const Prescribed& p) {
    return p.component != component || p.value <= *greatest++ + tolerance;
  });
}

/// Clamps every move into the interval that the holds allow.
void Clipper::cut_at_holds(int component, std::span<Prescribed> prescribed, double tolerance) {
  bounds_by(Kind::hold, component, prescribed, true);
  std::size_t i = 0;
  for (Prescribed& p : prescribed) {
    if (p.component != component)
      continue;
    if (!p.held && p.value > greatest_[i] + tolerance)
      p.value = greatest_[i];
    else if (!p.held && p.value < least_[i] - tolerance)
      p.value = least_[i];
    ++i;
  }
}

/// Replaces incompatible moves by the nearest compatible ones.
void Clipper::reconcile_moves(int component, std::span<Prescribed> prescribed, double tolerance) {
  bounds_by(Kind::move, component, prescribed, true);
  std::size_t i = 0;
  for (Prescribed& p : prescribed) {
    if (p.component != component)
      continue;
    const double minorant = greatest_[i], majorant = least_[i];
    ++i;
    const bool is_met = p.value <= minorant + tolerance && p.value >= majorant - tolerance;
    if (!p.held && !is_met)
      p.value = 0.5 * minorant + 0.5 * majorant; // no overflow for values near the largest
  }
}

std::int64_t Clipper::clip(int component, std::span<Prescribed> prescribed) {
  const double largest = largest_value(prescribed, component);
  if (largest == 0) // rest obeys every limit
    return 0;
  const double tolerance = rounding_tolerance(grid_, largest);
  if (can_all_be_met(component, prescribed, tolerance))
    return 0;
  requested_.clear();
  requested_.reserve(prescribed.size());
  for (const Prescribed& p : prescribed)
    requested_.push_back(p.value);
  cut_at_holds(component, prescribed, tolerance);
  reconcile_moves(component, prescribed, rounding_tolerance(grid_, largest_value(prescribed, component)));
  std::int64_t n_cut = 0;
  for (std::size_t i = 0; i < prescribed.size(); ++i)
    n_cut += prescribed[i].value != requested_[i] ? 1 : 0;
  return n_cut;
}

void tell_clipping(const Scene& scene, std::vector<Prescribed> clipped, std::optional<Status> stopped,
                   Answer& answer) {
  const Clipping clipping = compare_with_request(scene, std::move(clipped));
  answer.message = describe(scene, clipping);
  answer.n_cut = clipping.n_cut;
  answer.status = stopped.value_or(clipping.n_cut > 0 ? Status::clamped : Status::done);
}

double rounding_tolerance(const Grid& grid, double largest) {
  const Index3& n = grid.nodes();
  const double links = 8.0 + n[0] + n[1] + n[2];
  return links * std::numeric_limits<double>::epsilon() * largest;
}

void clip_component(const Scene& scene, const LinkLimits& limits, int component,
                    std::vector<Prescribed>& prescribed) {
  DijkstraBounds bounds(scene, limits);
  Clipper(bounds, scene.specimen.grid).clip(component, prescribed);
}

Clipping compare_with_request(const Scene& scene, std::vector<Prescribed> clipped) {
  Clipping clipping;
  for (std::size_t i = 0; i < clipped.size(); ++i) {
    const Prescribed& p = clipped[i];
    clipping.n_moves += p.held ? 0 : 1;
    const double cut = std::abs(p.value - scene.prescribed[i].value);
    clipping.n_cut += cut > 0 ? 1 : 0;
    if (cut > clipping.largest_cut) {
      clipping.largest_cut = cut;
      clipping.worst_node = p.node;
      clipping.worst_component = p.component;
    }
  }
  clipping.prescribed = std::move(clipped);
  return clipping;
}

Clipping clip(const Scene& scene, const LinkLimits& limits) {
  std::vector<Prescribed> prescribed = scene.prescribed;
  for (int component = 0; component < scene.dimension(); ++component)
    clip_component(scene, limits, component, prescribed);
  return compare_with_request(scene, std::move(prescribed));
}

namespace {

std::string what_allows_a_cut(const Scene& scene) {
  if (scene.limits.cut_is_allowed)
    return "";
  return scene.limits.from == LimitSource::none
             ? "; limits that the scene does not ask for, but that the method cannot do without: give wider "
               "ones, or allow the cut by "
               "[limits] cut = \"allowed\""
             : "; [limits] cut = \"allowed\" would take that for an answer";
}

} // namespace

std::string describe(const Scene& scene, const Clipping& clipping) {
  if (clipping.n_cut == 0)
    return {};
  const Vec3 x = scene.specimen.position(scene.specimen.grid.node_at(clipping.worst_node));
  return fmt::format("the limits permit only part of {} of {} moved components: the largest cut is {:.6g} m, "
                     "along {} at the node at ({:.6g}, {:.6g}, {:.6g}) m{}",
                     clipping.n_cut, clipping.n_moves, clipping.largest_cut, "xyz"[clipping.worst_component],
                     x[0], x[1], x[2], what_allows_a_cut(scene));
}

} // namespace maille::deform
