#include "maille/mechanics/recovery.hpp"

#include "patch_weights.hpp"

#include <algorithm>
#include <bit>
#include <map>

namespace maille {

namespace {

/// Part numbers of cells: one per label and material, in the order of their first cells.
std::vector<std::int32_t> parts_of(const Specimen& body) {
  std::vector<std::int32_t> part(body.grid.n_cells(), -1);
  std::map<std::pair<std::int32_t, std::uint8_t>, std::int32_t> known;
  for (std::size_t cell = 0; cell < part.size(); ++cell) {
    const std::uint8_t material = body.material(static_cast<std::int64_t>(cell));
    if (material == no_material)
      continue;
    const std::pair key(body.label.empty() ? 0 : body.label[cell], material);
    part[cell] = known.try_emplace(key, static_cast<std::int32_t>(known.size())).first->second;
  }
  return part;
}

/// The cells around a node, in the numbering of PatchWeights.
class Patch {
public:
  Patch(const Grid& grid, const Index3& node) : grid_(grid) {
    for (int a = 0; a < grid.dimension(); ++a) {
      low_[a] = node[a] - PatchWeights::across / 2;
      from_[a] = std::max(0, -low_[a]);
      to_[a] = std::min(PatchWeights::across, grid.cells()[a] - low_[a]);
    }
  }
  /// Bits of the cells of one part.
  std::uint64_t of(const std::vector<std::int32_t>& parts, std::int32_t part) const {
    std::uint64_t bits = 0;
    for (int z = from_[2]; z < to_[2]; ++z)
      for (int y = from_[1]; y < to_[1]; ++y) {
        const std::int64_t row = grid_.cell({low_[0], low_[1] + y, low_[2] + z});
        const int first = PatchWeights::across * (y + PatchWeights::across * z);
        for (int x = from_[0]; x < to_[0]; ++x)
          bits |= std::uint64_t{parts[row + x] == part} << (first + x);
      }
    return bits;
  }
  std::size_t cell(int bit) const {
    return static_cast<std::size_t>(
        grid_.cell({low_[0] + (bit & 3), low_[1] + (bit >> 2 & 3), low_[2] + (bit >> 4 & 3)}));
  }

private:
  const Grid& grid_;
  Index3 low_{}, from_{}, to_{1, 1, 1};
};

void add(RecoveredFields::Values& sum, double weight, const std::array<double, 6>& strain,
         const std::array<double, 6>& stress) {
  for (std::size_t k = 0; k < 6; ++k) {
    sum.strain[k] += weight * strain[k];
    sum.stress[k] += weight * stress[k];
  }
}

} // namespace

RecoveredFields::RecoveredFields(const Scene& scene, const CellFields& cells)
    : grid_(scene.specimen.grid), part_(parts_of(scene.specimen)) {
  PatchWeights weights(grid_.dimension());
  first_.reserve(static_cast<std::size_t>(grid_.n_nodes()) + 1);
  for (std::int64_t node = 0; node < grid_.n_nodes(); ++node) {
    const std::size_t first = parts_here_.size();
    first_.push_back(first);
    const Index3 at = grid_.node_at(node);
    scene.specimen.for_each_cell_at(at, [&](std::int64_t cell) {
      const std::int32_t part = part_[cell];
      const auto begin = parts_here_.begin() + static_cast<std::ptrdiff_t>(first);
      if (std::find(begin, parts_here_.end(), part) == parts_here_.end())
        parts_here_.push_back(part);
    });
    const Patch patch(grid_, at);
    for (std::size_t i = first; i < parts_here_.size(); ++i) {
      const std::uint64_t bits = weights.joined(patch.of(part_, parts_here_[i]));
      const PatchWeights::Coefficients& of_patch = weights.of(bits);
      Values& sum = values_.emplace_back();
      for (std::uint64_t left = bits; left != 0; left &= left - 1) {
        const int bit = std::countr_zero(left);
        const std::size_t cell = patch.cell(bit);
        add(sum, weights.weight(bit, of_patch), cells.strain[cell], cells.stress[cell]);
      }
    }
  }
  first_.push_back(parts_here_.size());
}

std::size_t RecoveredFields::place(std::int64_t cell, int corner) const {
  std::size_t i = first_[grid_.corner(grid_.cell_at(cell), corner)];
  while (parts_here_[i] != part_[cell])
    ++i;
  return i;
}

RecoveredFields::Values RecoveredFields::at(std::int64_t cell, const Vec3& in_cell) const {
  Values sum;
  for (int corner = 0; corner < grid_.corners_per_cell(); ++corner) {
    double weight = 1;
    for (int a = 0; a < grid_.dimension(); ++a)
      weight *= corner >> a & 1 ? in_cell[a] : 1 - in_cell[a];
    const Values& value = at_corner(cell, corner);
    add(sum, weight, value.strain, value.stress);
  }
  return sum;
}

RecoveredFields::Shown RecoveredFields::at_nodes() const {
  std::vector<int> cells(values_.size(), 0); // by node and part
  for (std::size_t cell = 0; cell < part_.size(); ++cell)
    for (int corner = 0; part_[cell] >= 0 && corner < grid_.corners_per_cell(); ++corner)
      ++cells[place(static_cast<std::int64_t>(cell), corner)];
  const auto n = static_cast<std::size_t>(grid_.n_nodes());
  Shown shown{std::vector<std::array<double, 6>>(n), std::vector<std::array<double, 6>>(n)};
  for (std::size_t node = 0; node < n; ++node) {
    std::size_t most = first_[node];
    for (std::size_t i = first_[node]; i < first_[node + 1]; ++i)
      if (cells[i] > cells[most] || (cells[i] == cells[most] && parts_here_[i] < parts_here_[most]))
        most = i;
    if (first_[node] == first_[node + 1])
      continue;
    shown.strain[node] = values_[most].strain;
    shown.stress[node] = values_[most].stress;
  }
  return shown;
}

} // namespace maille
