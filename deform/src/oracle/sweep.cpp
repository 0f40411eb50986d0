#include "oracle/sweep.hpp"

#include "control/method.hpp"
#include "feasible/limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace maille::deform {

namespace {

/// Disjoint sets of nodes (union-find with path halving).
class Groups {
public:
  explicit Groups(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t of(std::size_t node) {
    while (parent_[node] != node)
      node = parent_[node] = parent_[parent_[node]];
    return node;
  }
  void join(std::size_t a, std::size_t b) { parent_[std::max(of(a), of(b))] = std::min(of(a), of(b)); }

private:
  std::vector<std::size_t> parent_;
};

/// What acts on a group from outside.
struct Pull {
  double sum = 0; ///< of differences of displacement over the outer links
  std::int64_t links = 0;
  double room_up = std::numeric_limits<double>::infinity();
  double room_down = std::numeric_limits<double>::infinity();

  double reach() const {
    const double wanted = links > 0 ? std::abs(sum) / static_cast<double>(links) : 0;
    return std::min(wanted, sum > 0 ? room_up : room_down);
  }
};

/// One component's links and state, in short.
struct View {
  const LinkTable& table;
  const List<double>& u;
  std::span<const double> below, above;

  std::size_t begin(std::size_t node) const { return static_cast<std::size_t>(table.first()[node]); }
  std::size_t end(std::size_t node) const { return static_cast<std::size_t>(table.first()[node + 1]); }
  std::size_t other(std::size_t entry) const { return static_cast<std::size_t>(table.neighbour()[entry]); }
  double room_up(std::size_t node, std::size_t entry) const {
    return u[other(entry)] + above[entry] - u[node];
  }
  double room_down(std::size_t node, std::size_t entry) const {
    return u[node] - u[other(entry)] - below[entry];
  }
  /// Sum over a node's links of the neighbour's displacement less its own.
  double pull(std::size_t node) const {
    double sum = 0;
    for (std::size_t e = begin(node); e < end(node); ++e)
      sum += u[other(e)] - u[node];
    return sum;
  }
};

Groups join_stopped_links(const View& view, const std::vector<std::size_t>& free,
                          const std::vector<bool>& is_free, double rounding) {
  Groups groups(view.u.size());
  for (const std::size_t i : free) {
    const double pull = view.pull(i);
    if (std::abs(pull) <= rounding)
      continue;
    for (std::size_t e = view.begin(i); e < view.end(i); ++e) {
      const double room = pull > 0 ? view.room_up(i, e) : view.room_down(i, e);
      if (room <= rounding && is_free[view.other(e)])
        groups.join(i, view.other(e));
    }
  }
  return groups;
}

} // namespace

Jams find_jams(const LinkTable& table, const ComponentSweep& component, double rounding, double smallest) {
  const View view{table, component.values(), table.below(component.component()),
                  table.above(component.component())};
  const std::vector<std::size_t> free(component.free_nodes().begin(), component.free_nodes().end());
  std::vector<bool> is_free(view.u.size(), false);
  for (const std::size_t i : free)
    is_free[i] = true;
  Groups groups = join_stopped_links(view, free, is_free, rounding);

  List<Pull> pulls(view.u.size());
  for (const std::size_t i : free)
    for (std::size_t e = view.begin(i); e < view.end(i); ++e) {
      const std::size_t group = groups.of(i), other = view.other(e);
      if (is_free[other] && groups.of(other) == group)
        continue;
      Pull& pull = pulls[group];
      pull.sum += view.u[other] - view.u[i];
      pull.links += 1;
      pull.room_up = std::min(pull.room_up, view.room_up(i, e));
      pull.room_down = std::min(pull.room_down, view.room_down(i, e));
    }
  Jams jams;
  for (const Pull& pull : pulls)
    if (pull.reach() > smallest) {
      ++jams.groups;
      jams.farthest = std::max(jams.farthest, pull.reach());
    }
  return jams;
}

namespace {

/// What a node's neighbours say about it.
struct Neighbourhood {
  double mean;
  double lowest, highest; ///< the interval that the links leave; empty if lowest > highest
};

constexpr std::array<double, 7> one_over{0, 1.0, 1.0 / 2, 1.0 / 3, 1.0 / 4, 1.0 / 5, 1.0 / 6};

} // namespace

ComponentSweep::ComponentSweep(const LinkTable& table, int component, List<double> u,
                               const std::vector<Prescribed>& prescribed)
    : table_(table), component_(component), u_(std::move(u)) {
  std::vector<bool> is_fixed(u_.size(), false);
  for (const Prescribed& p : prescribed)
    if (p.component == component)
      is_fixed[table.body_node(p.node)] = true;
  for (std::size_t i = 0; i < u_.size(); ++i)
    if (!is_fixed[i] && table.first()[i + 1] > table.first()[i])
      free_.push_back(static_cast<std::int32_t>(i));
}

template<class Rule>
double ComponentSweep::sweep(Rule rule) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  // Raw pointers: this loop is the whole cost of the method.
  const std::int32_t* first = table_.first().data();
  const std::int32_t* neighbour = table_.neighbour().data();
  const double* below = table_.below(component_).data();
  const double* above = table_.above(component_).data();
  double* u = u_.data();
  double largest = 0;
  for (const std::int32_t i : free_) {
    double sum = 0, lowest = -infinity, highest = infinity;
    for (std::int32_t e = first[i]; e < first[i + 1]; ++e) {
      const double v = u[neighbour[e]];
      sum += v;
      lowest = std::max(lowest, v + below[e]);
      highest = std::min(highest, v + above[e]);
    }
    const double mean = sum * one_over[first[i + 1] - first[i]];
    const double next = rule(u[i], Neighbourhood{mean, lowest, highest});
    largest = std::max(largest, std::abs(next - u[i]));
    u[i] = next;
  }
  return largest;
}

double ComponentSweep::relax_elastic() {
  return sweep([](double now, const Neighbourhood& n) {
    // A feasible state leaves every node an interval, up to rounding; where that empties it, the node stays,
    // so that rounding does not add up from node to node.
    return n.lowest > n.highest ? now : std::min(std::max(n.mean, n.lowest), n.highest);
  });
}

double ComponentSweep::relax_deformable() {
  return sweep([](double now, const Neighbourhood& n) {
    return n.lowest > n.highest ? 0.5 * n.lowest + 0.5 * n.highest
                                : std::min(std::max(now, n.lowest), n.highest);
  });
}

namespace {

/// All components of one body on their way to rest.
class Relaxation {
public:
  Relaxation(const Scene& scene, const LinkTable& table, const Displacement& start,
             const std::vector<Prescribed>& prescribed);

  /// Sweeps until all components have settled; returns why it ended early, if it did.
  std::optional<Status> run(const Control& control, const Clock& clock);

  std::int64_t sweeps() const { return sweeps_; }
  double residual() const;
  void write_to(Displacement& displacement) const;
  /// Says where single nodes could do no more, though more could be done; empty if nowhere.
  std::string shortcomings(const Displacement& displacement) const;

private:
  struct Part {
    ComponentSweep component;
    ErrorEstimate error;
  };
  bool is_elastic() const { return settings_.mode == RelaxationMode::elastic; }
  bool has_settled(const Part& part) const { return part.error.remaining() <= settings_.tolerance * scale_; }
  double largest_remaining() const;
  void report(const Control& control);

  const RelaxationSettings& settings_;
  const LinkTable& table_;
  double scale_;    ///< largest displacement that is really prescribed [m]
  double rounding_; ///< of sums along the body [m]
  std::vector<Part> parts_;
  std::int64_t sweeps_ = 0;
  double first_remaining_ = 0;
};

Relaxation::Relaxation(const Scene& scene, const LinkTable& table, const Displacement& start,
                       const std::vector<Prescribed>& prescribed)
    : settings_(scene.relaxation), table_(table), scale_(0) {
  for (const Prescribed& p : prescribed)
    scale_ = std::max(scale_, std::abs(p.value));
  double largest = scale_; // a start may be larger than what is prescribed now
  for (int component = 0; component < scene.dimension(); ++component) {
    List<double> u = table.gather(start, component);
    for (const double value : u)
      largest = std::max(largest, std::abs(value));
    parts_.push_back({ComponentSweep(table, component, std::move(u), prescribed),
                      ErrorEstimate(4 * std::numeric_limits<double>::epsilon() * largest)});
  }
  if (scale_ == 0)
    scale_ = largest;
  rounding_ = rounding_tolerance(scene.specimen.grid, largest);
}

std::optional<Status> Relaxation::run(const Control& control, const Clock& clock) {
  for (bool all_settled = false; !all_settled;) {
    if (sweeps_ >= settings_.sweeps)
      return Status::budget_reached;
    if (const auto reason = reason_to_stop(control, clock))
      return reason;
    ++sweeps_;
    all_settled = true;
    for (Part& part : parts_) {
      if (sweeps_ > 1 && has_settled(part))
        continue;
      part.error.add(is_elastic() ? part.component.relax_elastic() : part.component.relax_deformable());
      all_settled = all_settled && has_settled(part);
    }
    report(control);
  }
  return std::nullopt;
}

double Relaxation::largest_remaining() const {
  double largest = 0;
  for (const Part& part : parts_)
    largest = std::max(largest, part.error.remaining());
  return largest;
}

double Relaxation::residual() const {
  const double remaining = largest_remaining();
  if (!std::isfinite(remaining)) // too few sweeps for an estimate
    return 1;
  return scale_ > 0 ? remaining / scale_ : 0;
}

void Relaxation::report(const Control& control) {
  if (!control.progress)
    return;
  const double remaining = largest_remaining(), goal = settings_.tolerance * scale_;
  double fraction = 0;
  if (std::isfinite(remaining)) {
    first_remaining_ = std::max(first_remaining_, remaining);
    if (remaining <= goal)
      fraction = 1;
    else if (first_remaining_ > goal && goal > 0)
      fraction = std::log(first_remaining_ / remaining) / std::log(first_remaining_ / goal);
  }
  control.progress(fraction, "relaxing");
}

void Relaxation::write_to(Displacement& displacement) const {
  for (const Part& part : parts_)
    table_.scatter(part.component.values(), part.component.component(), displacement);
}

std::string Relaxation::shortcomings(const Displacement& displacement) const {
  const double smallest = std::max(settings_.tolerance * scale_, rounding_);
  if (!is_elastic()) {
    const Violations broken = count_violations(table_, displacement, smallest);
    return broken.links == 0
               ? std::string{}
               : fmt::format("{} of {} links are still outside their limits, the worst by {:.6g} m",
                             broken.links, table_.n_links(), broken.worst);
  }
  Jams jams;
  for (const Part& part : parts_) {
    const Jams here = find_jams(table_, part.component, 4 * rounding_, smallest);
    jams.groups += here.groups;
    jams.farthest = std::max(jams.farthest, here.farthest);
  }
  return jams.groups == 0
             ? std::string{}
             : fmt::format("jammed: {} groups of nodes hold each other at their limits and would "
                           "move on only together, the most by {:.6g} m; this is not the least energy",
                           jams.groups, jams.farthest);
}

/// Puts the handles at their clipped values, and for the elastic mode lets the body follow.
Displacement placed(const Scene& scene, const LinkLimits& limits, const Clipping& clipping,
                    const Displacement& start) {
  Displacement state = start;
  if (scene.relaxation.mode == RelaxationMode::elastic)
    propagate(scene, limits, clipping.prescribed, state);
  else
    for (const Prescribed& p : clipping.prescribed)
      state(p.component, p.node) = p.value;
  return state;
}

Answer relax(const Scene& scene, const LinkLimits& limits, const Displacement& start, const Control& control,
             const Clock& clock) {
  const Clipping clipping = clip(scene, limits);
  const LinkTable table(scene, limits);
  Answer answer;
  answer.method = "sweep";
  answer.algorithm = scene.relaxation.mode == RelaxationMode::elastic
                         ? "Gauss-Seidel in node order, elastic: mean of the neighbours within the limits"
                         : "Gauss-Seidel in node order, deformable: least move into the limits";
  answer.displacement = placed(scene, limits, clipping, start);
  Relaxation relaxation(scene, table, answer.displacement, clipping.prescribed);
  answer.seconds.setup = clock.seconds();

  const std::optional<Status> stopped = relaxation.run(control, clock);
  relaxation.write_to(answer.displacement);
  answer.seconds.solve = clock.seconds() - answer.seconds.setup;
  answer.status = stopped ? *stopped : clipping.n_cut > 0 ? Status::clamped : Status::done;
  answer.n_cut = clipping.n_cut;
  answer.message = describe(scene, clipping);
  if (const std::string more = stopped ? "" : relaxation.shortcomings(answer.displacement); !more.empty())
    answer.message += (answer.message.empty() ? "" : "; ") + more;
  answer.iterations = relaxation.sweeps();
  answer.residual = relaxation.residual();
  return answer;
}

} // namespace

Answer relax_sweep(const Scene& scene, const LinkLimits& limits, const Displacement& start,
                   const Control& control) {
  if (std::string reason = reason_to_refuse(scene, "sweep"); !reason.empty())
    return refusal("sweep", std::move(reason));
  return relax(scene, limits, start, control, Clock{});
}

Answer solve_sweep(const Scene& scene, const Control& control) {
  if (std::string reason = reason_to_refuse(scene, "sweep"); !reason.empty())
    return refusal("sweep", std::move(reason));
  return in_arena("sweep", control, [&] {
    const Clock clock;
    const LinkLimits limits(scene);
    return relax(scene, limits, Displacement(scene.specimen.grid), control, clock);
  });
}

void ErrorEstimate::add(double change) {
  changes_.push_back(change);
  if (change == 0) {
    remaining_ = 0;
    return;
  }
  constexpr std::size_t shortest_window = 8;
  const std::size_t window = std::max(shortest_window, changes_.size() / 8);
  if (changes_.size() <= 2 * window)
    return;
  const double estimate = std::max(remaining_after(window), remaining_after(2 * window));
  if (change > rounding_)
    remaining_ = estimate;
  else // noise has no contraction; the earlier estimate stays
    remaining_ = std::isfinite(estimate) ? std::min(estimate, remaining_) : std::min(remaining_, change);
}

double ErrorEstimate::remaining_after(std::size_t window) const {
  const double now = changes_.back(), before = changes_[changes_.size() - 1 - window];
  if (now >= before)
    return std::numeric_limits<double>::infinity();
  const double rho = std::pow(now / before, 1.0 / static_cast<double>(window));
  return now * rho / (1 - rho);
}

std::int64_t bytes_for_sweep(const Scene& scene) {
  const std::int64_t nodes = scene.specimen.n_matter_nodes(), d = scene.dimension();
  const std::int64_t start = d * scene.specimen.grid.n_nodes() * std::int64_t{sizeof(double)},
                     parts = d * nodes * std::int64_t{sizeof(double) + 4 * sizeof(std::int32_t)};
  return bytes_at_least(scene) + start + LinkTable::bytes_for(scene.specimen) +
         std::max(parts, bytes_of_two_envelopes(scene)) + bytes_of_prescribed(scene);
}

} // namespace maille::deform
