#include "oracle/literal.hpp"

#include "control/method.hpp"
#include "feasible/bounds/clipping.hpp"
#include "lattice/link_table.hpp"

#include <algorithm>
#include <array>
#include <fmt/format.h>

namespace maille::deform {

namespace {

/// Gibson's six lists and the state that they work on.
class CandidateLists {
public:
  CandidateLists(const Scene& scene, const LinkTable& table);

  /// Puts all moved nodes at their targets and offers their neighbours.
  void place_handles(const Scene& scene);
  /// Processes the lists; returns why it ended early, if it did.
  std::optional<Status> run(const Control& control, const Clock& clock);

  std::int64_t visited() const { return visited_; }
  Displacement displacement(const Grid& grid) const;

  struct Candidate {
    std::int32_t sponsor;
    std::size_t entry; ///< of the link from the sponsor to the candidate
  };

private:
  void offer(std::int32_t node, int direction);
  bool follow(const Candidate& candidate, std::int32_t node);
  void offer_onward(std::int32_t node, int direction);

  const LinkTable& table_;
  std::vector<List<double>> u_;           ///< [component][node]
  std::vector<List<bool>> is_prescribed_; ///< [component][node]
  std::array<List<Candidate>, 6> list_;
  std::array<std::size_t, 6> head_{};
  std::int64_t visited_ = 0;
};

CandidateLists::CandidateLists(const Scene& scene, const LinkTable& table)
    : table_(table), u_(static_cast<std::size_t>(table.dimension()),
                        List<double>(static_cast<std::size_t>(table.n_nodes()), 0.0)),
      is_prescribed_(u_.size(), List<bool>(u_[0].size(), false)) {
  for (const Prescribed& p : scene.prescribed)
    is_prescribed_[p.component][static_cast<std::size_t>(table_.body_node(p.node))] = true;
}

void CandidateLists::place_handles(const Scene& scene) {
  std::vector<std::int32_t> moved;
  for (const Prescribed& p : scene.prescribed) {
    if (p.held)
      continue;
    moved.push_back(table_.body_node(p.node));
    u_[p.component][moved.back()] = p.value;
  }
  std::ranges::sort(moved);
  const auto repeated = std::ranges::unique(moved);
  moved.erase(repeated.begin(), repeated.end());
  for (const std::int32_t node : moved)
    for (int direction = 0; direction < 2 * table_.dimension(); ++direction)
      offer(node, direction);
}

void CandidateLists::offer(std::int32_t node, int direction) {
  const auto begin = static_cast<std::size_t>(table_.first()[node]);
  const auto end = static_cast<std::size_t>(table_.first()[static_cast<std::size_t>(node) + 1]);
  for (std::size_t e = begin; e < end; ++e)
    if (table_.direction()[e] == direction)
      list_[direction].push_back({node, e});
}

/// Moves a candidate as far as the link to its sponsor requires; true if it moved.
bool CandidateLists::follow(const Candidate& candidate, std::int32_t node) {
  const auto j = static_cast<std::size_t>(node), i = static_cast<std::size_t>(candidate.sponsor);
  bool has_moved = false;
  for (int component = 0; component < table_.dimension(); ++component) {
    const auto b = static_cast<std::size_t>(component);
    if (is_prescribed_[b][j])
      continue;
    // The entry is the sponsor's: u_i in [u_j + below, u_j + above].
    const double lowest = u_[b][i] - table_.above(component)[candidate.entry];
    const double highest = u_[b][i] - table_.below(component)[candidate.entry];
    const double followed = std::clamp(u_[b][j], lowest, highest);
    has_moved = has_moved || followed != u_[b][j];
    u_[b][j] = followed;
  }
  return has_moved;
}

void CandidateLists::offer_onward(std::int32_t node, int direction) {
  offer(node, direction);
  const int axis = direction / 2;
  for (int next = 2 * (axis + 1); next < 2 * table_.dimension(); ++next)
    offer(node, next);
}

std::optional<Status> CandidateLists::run(const Control& control, const Clock& clock) {
  constexpr std::int64_t visits_between_polls = 1 << 14;
  for (bool any = true; any;) {
    any = false;
    for (std::size_t d = 0; d < list_.size(); ++d) {
      for (; head_[d] < list_[d].size(); ++head_[d]) {
        any = true;
        if (++visited_ % visits_between_polls == 0)
          if (const auto reason = reason_to_stop(control, clock))
            return reason;
        const Candidate candidate = list_[d][head_[d]]; // a copy: the list may grow below
        const std::int32_t node = table_.neighbour()[candidate.entry];
        if (follow(candidate, node))
          offer_onward(node, static_cast<int>(d));
      }
      list_[d].clear();
      head_[d] = 0;
    }
  }
  return std::nullopt;
}

Displacement CandidateLists::displacement(const Grid& grid) const {
  Displacement displacement(grid);
  for (int b = 0; b < table_.dimension(); ++b)
    table_.scatter(u_[b], b, displacement);
  return displacement;
}

Answer propagate_literally(const Scene& scene, const Control& control) {
  const Clock clock;
  const LinkLimits limits(scene);
  const LinkTable table(scene, limits);
  CandidateLists lists(scene, table);
  Answer answer;
  answer.method = "literal";
  answer.algorithm = "candidate lists, first moved, first processed";
  answer.seconds.setup = clock.seconds();
  if (control.progress)
    control.progress(0, "propagating");
  lists.place_handles(scene);
  const std::optional<Status> stopped = lists.run(control, clock);
  answer.displacement = lists.displacement(scene.specimen.grid);
  answer.seconds.solve = clock.seconds() - answer.seconds.setup;

  const double tolerance = rounding_tolerance(scene.specimen.grid, scene.largest_prescribed());
  const Violations broken = count_violations(table, answer.displacement, tolerance);
  if (broken.links > 0)
    answer.message = fmt::format("{} of {} links are outside their limits, the worst by {:.6g} m",
                                 broken.links, table.n_links(), broken.worst);
  answer.status = stopped.value_or(Status::done);
  answer.iterations = lists.visited();
  return answer;
}

} // namespace

Answer solve_literal(const Scene& scene, const Control& control) {
  if (std::string reason = reason_to_refuse(scene, "literal"); !reason.empty())
    return refusal("literal", std::move(reason));
  return in_arena("literal", control, [&] { return propagate_literally(scene, control); });
}

std::int64_t bytes_for_literal(const Scene& scene) {
  const std::int64_t nodes = scene.specimen.n_matter_nodes(), d = scene.dimension();
  // Every link may offer its end once from either side; lists grow by doubling, into new memory.
  constexpr std::int64_t doubling = 3;
  return bytes_at_least(scene) + LinkTable::bytes_for(scene.specimen) +
         d * nodes * std::int64_t{sizeof(double)} + d * nodes / 8 +
         doubling * std::int64_t{sizeof(CandidateLists::Candidate)} * scene.specimen.n_matter_links() +
         bytes_of_prescribed(scene);
}

} // namespace maille::deform
