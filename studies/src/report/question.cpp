/// Summary of a scene in one sentence.

#include "report/body_pictures.hpp"
#include "text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace maille::studies {

namespace {

/// Lengths in millimetres, or in micrometres or metres if those have fewer digits.
std::string lengths(const std::vector<double>& metres, const char* between) {
  double largest = 0;
  for (const double length : metres)
    largest = std::max(largest, std::abs(length));
  const auto [unit, name] = largest >= 1                    ? std::pair(1.0, "m")
                            : largest < 1e-4 && largest > 0 ? std::pair(1e-6, "µm")
                                                            : std::pair(1e-3, "mm");
  std::string text;
  for (const double length : metres)
    text += fmt::format("{}{:.4g}", text.empty() ? "" : between,
                        std::abs(length) < 1e-9 * largest ? 0 : length / unit);
  return text + " " + name;
}

std::string with_and(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text += (i == 0 ? "" : i + 1 == words.size() ? " and " : ", ") + words[i];
  return text;
}

std::string body_of(const Scene& scene) {
  const Specimen& body = scene.specimen;
  const std::string shape = body.shape == "box"         ? "A box"
                            : body.shape == "ellipsoid" ? "An ellipsoid"
                            : body.shape == "muscle"    ? "A muscle belly"
                            : body.shape == "image"     ? "A body from an image"
                                                        : "A body";
  std::vector<double> sides;
  for (int axis = 0; axis < scene.dimension(); ++axis)
    sides.push_back(body.grid.cells()[axis] * body.grid.spacing()[axis]);
  std::set<std::uint8_t> used;
  std::set<int> labels;
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell)) {
      used.insert(body.material(cell));
      if (!body.label.empty())
        labels.insert(body.label[cell]);
    }
  std::vector<std::string> materials;
  for (const std::uint8_t id : used)
    if (const std::string& name = scene.materials[id].name; !name.empty() && name != "specimen.material")
      materials.push_back(name); // an unnamed material is named by its key
  constexpr std::size_t most_names = 3;
  const std::string matter = labels.size() > 1 ? fmt::format(", {} labels", labels.size()) +
                                                     (materials.size() == 1 ? " of " + materials.front() : "")
                             : materials.empty() ? ""
                             : materials.size() <= most_names
                                 ? " of " + with_and(materials)
                                 : fmt::format(" of {} materials", materials.size());
  return fmt::format("{} of {}{}", shape, lengths(sides, " × "), matter);
}

std::string name_of(const Scene& scene, std::int32_t condition, const std::string& kind) {
  if (condition < 0)
    return "some nodes";
  const std::string& where = scene.conditions[condition].where;
  constexpr std::size_t longest = 24; // longer names, and regions in braces, are omitted
  return where.empty() || where.size() > longest || where.find('{') != std::string::npos
             ? scene.conditions[condition].name
             : (kind.empty() ? "" : kind + " ") + where;
}

std::string movement_of(const Scene& scene, std::int32_t condition) {
  std::array<double, 3> sums{};
  std::array<int, 3> n{};
  double least = INFINITY, most = 0;
  for (const Prescribed& one : scene.prescribed)
    if (!one.held && one.condition == condition) {
      const std::size_t c = one.component;
      sums[c] += one.value;
      ++n[c];
      least = std::min(least, std::abs(one.value));
      most = std::max(most, std::abs(one.value));
    }
  for (const Turn& turn : scene.turns)
    if (most > 0 && std::ranges::any_of(scene.prescribed, [&](const Prescribed& one) {
          return one.condition == condition && std::ranges::binary_search(turn.nodes, one.node);
        }))
      return fmt::format("turned by {:.4g}°", turn.angle * 180 / std::numbers::pi);
  std::vector<double> by;
  for (int c = 0; c < scene.dimension(); ++c)
    by.push_back(n[c] > 0 ? sums[c] / n[c] : 0);
  std::string text = lengths(by, ", ");
  const std::size_t unit = text.rfind(' ');
  return fmt::format("moved by ({}){}", text.substr(0, unit), text.substr(unit));
}

std::vector<std::string> done_to(const Scene& scene) {
  std::set<std::int32_t> held, moved, loaded;
  for (const Prescribed& one : scene.prescribed)
    (one.held ? held : moved).insert(one.condition);
  for (const FaceLoad& load : scene.tractions)
    loaded.insert(load.condition);
  std::vector<std::string> holds, words;
  constexpr std::size_t most_names = 4;
  for (const std::int32_t condition : held)
    holds.push_back(name_of(scene, condition, ""));
  if (!holds.empty())
    words.push_back("held at " +
                    (holds.size() <= most_names ? with_and(holds) : fmt::format("{} places", holds.size())));
  if (moved.size() > most_names)
    words.push_back(fmt::format("moved at {} places", moved.size()));
  else
    for (const std::int32_t condition : moved)
      words.push_back(name_of(scene, condition, "") + " " + movement_of(scene, condition));
  for (const std::int32_t condition : loaded)
    words.push_back("pulled at " + name_of(scene, condition, ""));
  if (scene.gravity != Vec3{0, 0, 0})
    words.push_back("under its weight");
  if (scene.contracts())
    words.push_back("its fibres contracting up to " +
                    in_pascals(*std::ranges::max_element(scene.active_stress)));
  return words;
}

} // namespace

std::string question_of(const Scene& scene) {
  std::string text = body_of(scene);
  for (const std::string& words : done_to(scene))
    text += ", " + words;
  if (scene.test)
    return text + fmt::format(": how stiff is it in this {} test, and where do strain and stress go?",
                              to_string(scene.test->kind));
  const bool is_moved =
      std::ranges::any_of(scene.prescribed, [](const Prescribed& one) { return !one.held; });
  return text + (is_moved ? ": what force does it take, and where do strain and stress go?"
                          : ": how far does it give way, and where do strain and stress go?");
}

} // namespace maille::studies
