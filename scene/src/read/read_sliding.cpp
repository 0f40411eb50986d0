// Reads borders between labels that slide.
#include "maille/scene/plausibility.hpp"
#include "maille/scene/sliding.hpp"
#include "read/reader.hpp"
#include "voxels/label_cells.hpp"

#include <algorithm>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace maille::reader {

namespace {

/// Pairs of labels that share a face.
std::set<std::pair<std::int32_t, std::int32_t>> touching_labels(const Specimen& body) {
  std::set<std::pair<std::int32_t, std::int32_t>> pairs;
  const Grid& grid = body.grid;
  for (std::int64_t cell = 0; cell < grid.n_cells(); ++cell)
    for (int axis = 0; body.is_matter(cell) && axis < grid.dimension(); ++axis) {
      Index3 beyond = grid.cell_at(cell);
      ++beyond[axis];
      if (!grid.has_cell(beyond) || !body.is_matter(grid.cell(beyond)))
        continue;
      const std::int32_t one = body.label[cell], other = body.label[grid.cell(beyond)];
      if (one != other)
        pairs.insert(std::minmax(one, other));
    }
  return pairs;
}

std::string in_words(const std::set<std::pair<std::int32_t, std::int32_t>>& pairs) {
  std::string text;
  for (const auto& [one, other] : pairs)
    text += fmt::format("{}[{}, {}]", text.empty() ? "" : ", ", one, other);
  return text.empty() ? "none" : text;
}

/// Pairs of one table. @param is_all  true if it names no labels
std::vector<SlidingBorder> read_pairs(TableReader& table, const Scene& scene, bool has_body, bool& is_all) {
  double friction = 0;
  table.read("friction", friction);
  const toml::node* node = table.require("between");
  if (!node)
    return {};
  const auto* list = node->as_array();
  is_all = node->value_exact<std::string>() == "all";
  std::vector<std::int32_t> labels;
  for (std::size_t i = 0; list && i < list->size(); ++i)
    if (const auto number = list->get(i)->value_exact<std::int64_t>(); number && is_label(*number))
      labels.push_back(static_cast<std::int32_t>(*number));
  if (!is_all && (!list || list->size() != 2 || labels.size() != 2 || labels[0] == labels[1])) {
    table.fault("between", "two labels that touch, such as [17, 30], or \"all\"");
    return {};
  }
  if (!has_body)
    return {};
  if (scene.dimension() != 3 || scene.specimen.label.empty()) {
    table.fault("between", "a three-dimensional body with labels, as `labels` of an image gives it",
                scene.dimension() != 3 ? fmt::format("{} dimensions", scene.dimension()) : "none");
    return {};
  }
  const auto touching = touching_labels(scene.specimen);
  std::vector<SlidingBorder> pairs;
  if (is_all)
    for (const auto& [one, other] : touching)
      pairs.push_back({one, other, friction});
  else if (touching.contains(std::minmax(labels[0], labels[1])))
    pairs.push_back({labels[0], labels[1], friction});
  if (pairs.empty())
    table.fault("between", "labels whose voxels share faces: " + in_words(touching));
  return pairs;
}

} // namespace

void read_sliding(TableReader& root, Scene& scene, bool has_body) {
  int line = 0;
  std::vector<SlidingBorder> named;
  const std::size_t faults_before = root.faults().size();
  for_each_table(root, "sliding", [&](TableReader& table) {
    line = line > 0 ? line : table.line();
    bool is_all = false;
    for (const SlidingBorder& pair : read_pairs(table, scene, has_body, is_all)) {
      const auto is_same = [&](const SlidingBorder& border) {
        return std::minmax(border.one, border.other) == std::minmax(pair.one, pair.other);
      };
      const auto known = std::ranges::find_if(scene.sliding, is_same);
      const bool is_named = std::ranges::any_of(named, is_same);
      if (known == scene.sliding.end())
        scene.sliding.push_back(pair);
      else if (!is_all && is_named && known->friction != pair.friction)
        table.fault("friction", fmt::format("{}, as an earlier table has it", known->friction),
                    fmt::format("{}", pair.friction));
      else if (!is_all || !is_named) // named labels take precedence
        *known = pair;
      if (!is_all)
        named.push_back(pair);
    }
  });
  if (scene.sliding.empty() || root.faults().size() > faults_before || scene.prescribed.empty())
    return;
  // The methods report motions that are free without sliding, too, as for any scene.
  Scene joined = scene;
  joined.sliding.clear();
  if (const std::string motion = remaining_rigid_motion(scene);
      !motion.empty() && remaining_rigid_motion(joined).empty())
    root.faults().add(line, "sliding", "labels that something keeps in place once their borders slide",
                      motion + ": hold it, join it to a neighbour, or give it a foundation");
}

} // namespace maille::reader
