#include "trade/lattices.hpp"

#include "maille/materials/fault.hpp"
#include "maille/materials/text_file.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/refined.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace maille::studies {

namespace {

/// Integers of `node`, one or a list.
std::vector<std::int64_t> whole_numbers(const toml::node* node) {
  std::vector<std::int64_t> numbers;
  if (const auto* list = node ? node->as_array() : nullptr)
    for (const toml::node& entry : *list)
      numbers.push_back(entry.value_or(std::int64_t{1}));
  else if (node)
    numbers.push_back(node->value_or(std::int64_t{1}));
  return numbers;
}

template<class Number>
toml::array list_of(const std::vector<Number>& numbers) {
  toml::array list;
  for (const Number& number : numbers)
    list.push_back(number);
  return list;
}

/// Sets fewer cells over the same extent. @return false if no axis has fewer
bool coarsen_generated(toml::table& specimen, const Grid& grid, int factor) {
  std::vector<std::int64_t> cells = whole_numbers(specimen.get("cells"));
  std::vector<std::string> spacing;
  bool is_coarser = false;
  for (std::size_t a = 0; a < cells.size(); ++a) {
    const auto even = std::llround(static_cast<double>(cells[a]) / static_cast<double>(factor));
    const std::int64_t fewer = std::max(std::int64_t{1}, static_cast<std::int64_t>(even));
    is_coarser = is_coarser || fewer < cells[a];
    spacing.push_back(
        fmt::format("{} m", grid.spacing()[a] * static_cast<double>(cells[a]) / static_cast<double>(fewer)));
    cells[a] = fewer;
  }
  specimen.insert_or_assign("cells", list_of(cells));
  specimen.insert_or_assign("spacing", list_of(spacing));
  return is_coarser;
}

/// Divides every cell of a box into `factor` parts along each axis.
void refine_box(toml::table& specimen, const Grid& grid, int factor) {
  std::vector<std::int64_t> cells;
  std::vector<std::string> spacing;
  for (int a = 0; a < grid.dimension(); ++a) {
    cells.push_back(std::int64_t{grid.cells()[a]} * factor);
    spacing.push_back(fmt::format("{} m", grid.spacing()[a] / factor));
  }
  specimen.insert_or_assign("cells", list_of(cells));
  specimen.insert_or_assign("spacing", list_of(spacing));
}

std::string as_text(const toml::table& document) {
  std::ostringstream text;
  text << document;
  return text.str() + "\n";
}

/// Removes measures, because a coarse lattice may lack cells at their positions.
std::string without_measures(const std::string& text) {
  toml::table document = parse_toml(text, "");
  document.erase("measure");
  return as_text(document);
}

} // namespace

void coarsen_image(toml::table& specimen, int factor) {
  std::vector<std::int64_t> blocks = whole_numbers(specimen.get("coarsen"));
  if (blocks.empty())
    blocks = {1};
  for (std::int64_t& block : blocks)
    block *= factor;
  if (blocks.size() == 1)
    specimen.insert_or_assign("coarsen", blocks.front());
  else
    specimen.insert_or_assign("coarsen", list_of(blocks));
}

Lattices::Lattices(const std::filesystem::path& file)
    : Lattices(read_text_file(file, "a scene file"), file) {}

Lattices::Lattices(std::string text, std::filesystem::path file)
    : Lattices(text, file, parse_scene_and_measures(text, file)) {}

Lattices::Lattices(std::string text, std::filesystem::path file, SceneAndMeasures read)
    : text_(std::move(text)), file_(std::move(file)),
      scene_(std::make_shared<const Scene>(std::move(read.scene))),
      measures_(std::make_shared<const std::vector<Measure>>(std::move(read.measures))) {}

LatticeScene Lattices::at(int halvings) {
  if (halvings == 0)
    return {scene_, {}, measures_};
  if (const auto known = known_.find(halvings); known != known_.end())
    return known->second;
  LatticeScene found;
  if (halvings < 0)
    found = coarser(-halvings);
  else if (const LatticeScene next = at(halvings - 1); next.scene) {
    found.scene = std::make_shared<const Scene>(refined(*next.scene));
    found.measures = next.measures->empty() ? next.measures
                                            : std::make_shared<const std::vector<Measure>>(
                                                  refined(*next.measures, *next.scene, *found.scene));
  }
  return known_[halvings] = found;
}

std::vector<Measure> Lattices::measures_on(const Scene& scene) const {
  if (&scene == scene_.get())
    return *measures_;
  for (const auto& [halvings, known] : known_)
    if (&scene == known.scene.get() && known.measures)
      return *known.measures;
  return {};
}

std::string Lattices::coarsen(int doublings, std::string& text) const {
  toml::table document = parse_toml(text_, file_.string());
  toml::table& specimen = *document.get("specimen")->as_table();
  const int factor = 1 << doublings;
  if (scene_->specimen.shape == "image")
    coarsen_image(specimen, factor);
  else if (!coarsen_generated(specimen, scene_->specimen.grid, factor))
    return "one cell along every axis: there is no coarser lattice";
  text = as_text(document);
  return {};
}

LatticeScene Lattices::coarser(int doublings) const {
  std::string text;
  if (std::string why_not = coarsen(doublings, text); !why_not.empty())
    return {nullptr, std::move(why_not)};
  try {
    SceneAndMeasures read = parse_scene_and_measures(text, file_);
    return {std::make_shared<const Scene>(std::move(read.scene)),
            {},
            std::make_shared<const std::vector<Measure>>(std::move(read.measures))};
  } catch (const InputError& error) {
    if (std::ranges::all_of(error.faults(),
                            [](const Fault& fault) { return fault.key.starts_with("measure["); }))
      return {std::make_shared<const Scene>(parse_scene(without_measures(text), file_)), {}};
    // Line numbers would refer to generated text.
    const Fault& fault = error.faults().front();
    return {nullptr, fmt::format("{}: expected {}, found {}", fault.key, fault.expected, fault.found)};
  }
}

std::optional<std::string> Lattices::text(int halvings, std::optional<double> tolerance) const {
  std::string text = text_;
  if (halvings < 0 && !coarsen(-halvings, text).empty())
    return std::nullopt;
  if (const auto known = known_.find(halvings); known != known_.end() && !known->second.measures)
    text = without_measures(text);
  toml::table document = parse_toml(text, file_.string());
  if (halvings > 0) {
    if (scene_->specimen.shape != "box")
      return std::nullopt;
    refine_box(*document.get("specimen")->as_table(), scene_->specimen.grid, 1 << halvings);
  }
  if (tolerance) {
    if (!document.contains("relaxation"))
      document.insert("relaxation", toml::table{});
    document.get("relaxation")->as_table()->insert_or_assign("tolerance", *tolerance);
  }
  return as_text(document);
}

} // namespace maille::studies
