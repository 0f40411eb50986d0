#include "body_numbering.hpp"
#include "maille/base/vectors.hpp"

#include <cmath>
#include <queue>

namespace maille::studies {

namespace {

/// Maximum spanning trees over the faces between cells (Prim 1957); the sign of a fibre is set when its cell
/// joins the tree.
class SignTree {
public:
  SignTree(const Specimen& specimen, const Placement& placement);
  std::vector<Vec3> fibres() && { return std::move(fibre_); }

private:
  /// A candidate cell, and how nearly parallel its fibre is to that of the neighbour in the tree.
  struct Candidate {
    double parallel = 0;
    std::int64_t cell = 0, from = 0;
    bool operator<(const Candidate& other) const {
      return parallel != other.parallel ? parallel < other.parallel : cell > other.cell;
    }
  };
  void grow_from(std::int64_t seed);
  void offer_neighbours(std::int64_t cell);
  void point_ahead(const std::vector<std::int64_t>& part);

  const Specimen& specimen_;
  const Placement& placement_;
  std::vector<Vec3> fibre_;
  std::vector<bool> has_joined_;
  std::priority_queue<Candidate> candidates_;
};

SignTree::SignTree(const Specimen& specimen, const Placement& placement)
    : specimen_(specimen), placement_(placement),
      fibre_(static_cast<std::size_t>(specimen.grid.n_cells()), Vec3{0, 0, 0}), has_joined_(fibre_.size()) {
  const std::int64_t n = specimen.grid.n_cells();
  for (std::int64_t cell = 0; cell < n; ++cell)
    if (specimen.is_matter(cell))
      fibre_[cell] = specimen.fibre_of(cell);
  if (specimen.fibres.empty())
    return;
  for (std::int64_t cell = 0; cell < n; ++cell)
    if (specimen.is_matter(cell) && !has_joined_[cell])
      grow_from(cell);
}

void SignTree::offer_neighbours(std::int64_t cell) {
  const Grid& grid = specimen_.grid;
  const Index3 place = grid.cell_at(cell);
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const int step : {-1, 1}) {
      Index3 beside = place;
      beside[axis] += step;
      if (!grid.has_cell(beside))
        continue;
      const std::int64_t next = grid.cell(beside);
      const std::size_t n = next;
      if (specimen_.is_matter(next) && !has_joined_[n])
        candidates_.push({std::abs(dot(fibre_[n], fibre_[cell])), next, cell});
    }
}

void SignTree::grow_from(std::int64_t seed) {
  std::vector<std::int64_t> part;
  candidates_.push({0, seed, seed});
  while (!candidates_.empty()) {
    const Candidate next = candidates_.top();
    candidates_.pop();
    const std::size_t n = next.cell;
    if (has_joined_[n])
      continue;
    has_joined_[n] = true;
    part.push_back(next.cell);
    if (dot(fibre_[n], fibre_[next.from]) < 0)
      for (double& component : fibre_[n])
        component = -component;
    offer_neighbours(next.cell);
  }
  point_ahead(part);
}

void SignTree::point_ahead(const std::vector<std::int64_t>& part) {
  Vec3 sum{};
  for (const std::int64_t cell : part)
    for (std::size_t axis = 0; axis < 3; ++axis)
      sum[axis] += fibre_[cell][axis];
  sum = to_world(placement_, sum);
  double longest = 0;
  for (const double component : sum)
    if (std::abs(component) > std::abs(longest))
      longest = component;
  if (longest < 0)
    for (const std::int64_t cell : part)
      for (double& component : fibre_[cell])
        component = -component;
}

} // namespace

std::vector<Vec3> with_one_sign(const Specimen& specimen, const Placement& placement) {
  return SignTree(specimen, placement).fibres();
}

} // namespace maille::studies
