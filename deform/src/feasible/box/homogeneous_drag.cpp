#include "feasible/bounds/clipping.hpp"
#include "feasible/bounds/drag_engine.hpp"
#include "feasible/box/separable_scans.hpp"
#include "lattice/body.hpp"
#include "maille/deform/plan.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

/// Distance of the stored part of a handle from its offset, in slack ranges, at which the offset follows.
constexpr double ranges_before_rebase = 4;

class HomogeneousDrag : public DragEngine {
public:
  HomogeneousDrag(const Scene& scene, const LinkLimits& limits, int threads);

  bool take(DragHandle& handle) override;
  std::int64_t move(std::span<DragHandle> handles) override;
  double displacement(int component, std::int64_t node) const override {
    return body_.is_matter(node) ? body_.displacement(component, body_.grid().node_at(node)) : 0;
  }
  void copy_to(Displacement& state) const override { body_.copy_to(state); }
  Drag::Residue residue() const override;
  const std::string& algorithm() const override { return algorithm_; }

private:
  void clip_one(DragHandle& moving, std::span<const DragHandle> handles);
  void clip_many(std::span<DragHandle> handles);
  std::int64_t drag_one_by_one(std::span<DragHandle> handles);
  std::int64_t drag_at_once(std::span<DragHandle> handles);
  void follow(std::span<const DragHandle> handles);
  void restore(std::span<const DragHandle> handles);
  void rebase(std::span<const DragHandle> handles);

  double rigid_part(std::size_t component, const DragHandle& handle) const;
  double stored(std::size_t component, double value) const {
    return value - body_.offset(static_cast<int>(component));
  }
  double stored_target(std::size_t component, const DragHandle& handle) const;
  std::size_t dimension() const { return static_cast<std::size_t>(body_.dimension()); }

  const Scene& scene_;
  Body body_;
  std::array<LinkIntervals<double>, 3> steps_;
  Vec3 range_{}; ///< slack_range per component
  ThreadTeam team_;
  BoxBounds bounds_;
  Clipper clipper_;
  ClosedForm<float> closed_form_;
  SeparableScans<float> scans_;
  std::array<Rounding, 3> rounding_;
  std::vector<Prescribed> asked_;
  std::vector<HandleValue> values_;
  bool has_holds_ = false, is_at_end_ = false;
  std::string algorithm_{to_string(Algorithm::rest)};
};

HomogeneousDrag::HomogeneousDrag(const Scene& scene, const LinkLimits& limits, int threads)
    : scene_(scene), body_(scene), steps_(intervals_by_axis(scene, limits)), team_(threads),
      bounds_(scene.specimen.grid, steps_), clipper_(bounds_, scene.specimen.grid),
      closed_form_(scene.specimen.grid), scans_(scene.specimen.grid, steps_, threads) {
  for (std::size_t b = 0; b < dimension(); ++b)
    range_[b] = slack_range(steps_[b], scene.specimen.grid.nodes());
  has_holds_ = std::ranges::any_of(scene.prescribed, &Prescribed::held);
}

/// Interval of a handle from values at other nodes: Theorem 4, pair by pair.
void narrow(double& least, double& greatest, const LinkIntervals<double>& steps, const Index3& handle,
            const Index3& other, double value) {
  const Slopes down(steps, Side::least), up(steps, Side::greatest);
  double low = value, high = value;
  for (std::size_t a = 0; a < 3; ++a) {
    low += down.along(a, handle[a] - other[a]);
    high += up.along(a, handle[a] - other[a]);
  }
  least = std::max(least, low);
  greatest = std::min(greatest, high);
}

bool HomogeneousDrag::take(DragHandle& handle) {
  if (!body_.fills_its_grid() && !reaches_all_monotonely(scene_.specimen, handle.at))
    return false;
  for (const Prescribed& p : scene_.prescribed)
    if (p.held) {
      const auto b = static_cast<std::size_t>(p.component);
      narrow(handle.least[b], handle.greatest[b], steps_[b], handle.at, body_.grid().node_at(p.node),
             p.value);
    }
  return true;
}

/// Clamps the moving handle into the interval that holds and other handles allow.
void HomogeneousDrag::clip_one(DragHandle& moving, std::span<const DragHandle> handles) {
  for (std::size_t b = 0; b < dimension(); ++b) {
    if (body_.is_held(static_cast<int>(b), moving.node)) {
      moving.target[b] = moving.value[b];
      continue;
    }
    double least = moving.least[b], greatest = moving.greatest[b];
    double largest = std::abs(moving.target[b]);
    for (const DragHandle& other : handles)
      if (!other.is_moving) {
        narrow(least, greatest, steps_[b], moving.at, other.at, other.value[b]);
        largest = std::max(largest, std::abs(other.value[b]));
      }
    const double tolerance = rounding_tolerance(body_.grid(), largest);
    if (moving.target[b] > greatest + tolerance)
      moving.target[b] = greatest;
    else if (moving.target[b] < least - tolerance)
      moving.target[b] = least;
    const double margin = safe_margin<float>(body_.grid().nodes(), rounding_[b].largest);
    is_at_end_ = is_at_end_ || greatest - moving.target[b] <= margin || moving.target[b] - least <= margin;
  }
}

void HomogeneousDrag::clip_many(std::span<DragHandle> handles) {
  asked_.clear();
  for (const Prescribed& p : scene_.prescribed)
    if (p.held)
      asked_.push_back(p);
  const std::size_t n_holds = asked_.size();
  for (const DragHandle& handle : handles)
    for (std::size_t b = 0; b < dimension(); ++b)
      if (const int component = static_cast<int>(b); !body_.is_held(component, handle.node))
        asked_.push_back({handle.node, component, handle.is_moving ? handle.target[b] : handle.value[b],
                          !handle.is_moving});
  for (int component = 0; component < body_.dimension(); ++component)
    clipper_.clip(component, asked_);
  auto clipped = asked_.cbegin() + static_cast<std::ptrdiff_t>(n_holds);
  for (DragHandle& handle : handles)
    for (std::size_t b = 0; b < dimension(); ++b) {
      const bool is_held = body_.is_held(static_cast<int>(b), handle.node);
      if (handle.is_moving)
        handle.target[b] = is_held ? handle.value[b] : clipped->value;
      clipped += is_held ? 0 : 1;
    }
  is_at_end_ = true;
}

/// The part of a handle's move that every node must follow, whatever its slack.
double HomogeneousDrag::rigid_part(std::size_t b, const DragHandle& handle) const {
  const double by = handle.target[b] - handle.value[b];
  double slack = 0;
  for (std::size_t a = 0; a < 3; ++a) {
    const int farthest = std::max(handle.at[a], body_.grid().nodes()[a] - 1 - handle.at[a]);
    slack += farthest * (steps_[b].high[a] - steps_[b].low[a]);
  }
  return by > slack ? by - slack : by < -slack ? by + slack : 0;
}

/// Stored value of a moving handle. If the offset has taken the whole move, the stored value does not change
/// by an ulp.
double HomogeneousDrag::stored_target(std::size_t b, const DragHandle& handle) const {
  const int component = static_cast<int>(b);
  const double now = double{body_.field(component).at(handle.at)}, target = stored(b, handle.target[b]);
  const double ulps = 4 * std::numeric_limits<double>::epsilon() * std::abs(body_.offset(component));
  return std::abs(target - now) <= ulps ? now : target;
}

/// Moves the common part of the motion into the offsets.
void HomogeneousDrag::follow(std::span<const DragHandle> handles) {
  for (std::size_t b = 0; b < dimension(); ++b) {
    double part = 0;
    for (const DragHandle& handle : handles)
      if (handle.is_moving) {
        const double other = rigid_part(b, handle);
        part = std::abs(other) > std::abs(part) ? other : part;
      }
    if (part != 0)
      body_.set_offset(static_cast<int>(b), body_.offset(static_cast<int>(b)) + part);
  }
}

std::int64_t HomogeneousDrag::drag_one_by_one(std::span<DragHandle> handles) {
  std::int64_t visited = 0;
  for (const DragHandle& handle : handles) {
    if (!handle.is_moving)
      continue;
    for (std::size_t b = 0; b < dimension(); ++b)
      closed_form_.add(static_cast<int>(b), body_.field(static_cast<int>(b)), steps_[b], handle.at,
                       stored_target(b, handle), rounding_[b]);
    visited += closed_form_.run(team_);
  }
  return visited;
}

std::int64_t HomogeneousDrag::drag_at_once(std::span<DragHandle> handles) {
  for (std::size_t b = 0; b < dimension(); ++b) {
    values_.clear();
    for (const DragHandle& handle : handles)
      if (handle.is_moving)
        values_.push_back({handle.at, stored_target(b, handle)});
    std::ranges::sort(values_, {}, [&](const HandleValue& value) { return body_.grid().node(value.at); });
    scans_.add(static_cast<int>(b), body_.field(static_cast<int>(b)), values_, rounding_[b]);
  }
  return scans_.run(team_);
}

/// Restores fixed nodes after rounding.
void HomogeneousDrag::restore(std::span<const DragHandle> handles) {
  for (const DragHandle& handle : handles)
    for (std::size_t b = 0; b < dimension(); ++b) {
      const double value = handle.is_moving ? stored_target(b, handle) : stored(b, handle.value[b]);
      body_.field(static_cast<int>(b)).at(handle.at) = static_cast<float>(value) + 0.0F;
    }
  if (has_holds_ && is_at_end_)
    for (const Prescribed& p : scene_.prescribed)
      if (p.held)
        body_.field(p.component).at(body_.grid().node_at(p.node)) =
            static_cast<float>(stored(static_cast<std::size_t>(p.component), p.value)) + 0.0F;
}

/// Keeps stored numbers small: once a handle has carried the body away by several times its slack, the whole
/// body is near the handle, and the offset moves there. One pass, after all nodes have moved at least three
/// times as far.
void HomogeneousDrag::rebase(std::span<const DragHandle> handles) {
  const auto moving = std::ranges::find_if(handles, &DragHandle::is_moving);
  for (std::size_t b = 0; b < dimension(); ++b) {
    const int component = static_cast<int>(b);
    const float by = body_.field(component).at(moving->at);
    if (double{std::abs(by)} <= ranges_before_rebase * range_[b])
      continue;
    const Field<float> field = body_.field(component);
    float* const end = field.data + field.slab_stride * field.nodes[2];
    for (float* value = field.data; value != end; ++value)
      *value -= by;
    body_.set_offset(component, body_.offset(component) + double{by});
    rounding_[b].largest = 2 * range_[b];
  }
}

std::int64_t HomogeneousDrag::move(std::span<DragHandle> handles) {
  const auto n_moving = static_cast<std::size_t>(std::ranges::count_if(handles, &DragHandle::is_moving));
  if (n_moving == 0)
    return 0;
  is_at_end_ = false;
  if (n_moving == 1)
    clip_one(*std::ranges::find_if(handles, &DragHandle::is_moving), handles);
  else
    clip_many(handles);
  follow(handles);
  const bool at_once = n_moving > most_handles_one_by_one && body_.fills_its_grid();
  const std::int64_t visited = at_once ? drag_at_once(handles) : drag_one_by_one(handles);
  algorithm_ = to_string(at_once ? Algorithm::separable_scans : Algorithm::closed_form);
  restore(handles);
  rebase(handles);
  return visited;
}

Drag::Residue HomogeneousDrag::residue() const {
  Drag::Residue residue;
  const Index3& n = body_.grid().nodes();
  for (int component = 0; component < body_.dimension(); ++component) {
    const Field<const float> field = body_.field(component);
    std::int64_t node = 0;
    for (int z = 0; z < n[2]; ++z)
      for (int y = 0; y < n[1]; ++y)
        for (int x = 0; x < n[0]; ++x, ++node)
          if (const double u = std::abs(body_.offset(component) + double{field.row(y, z)[x]});
              u > residue.largest && body_.is_matter(node))
            residue = {u, node, component};
  }
  return residue;
}

} // namespace

std::unique_ptr<DragEngine> make_homogeneous_drag(const Scene& scene, const LinkLimits& limits, int threads) {
  return std::make_unique<HomogeneousDrag>(scene, limits, threads);
}

} // namespace maille::deform
