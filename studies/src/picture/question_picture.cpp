#include "picture/question_picture.hpp"

#include "drawing.hpp"
#include "export/body_grid.hpp"
#include "layout.hpp"
#include "question_actors.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace maille::studies {

namespace {

/// Entry of the legend under a picture.
struct LegendEntry {
  Vec3 colour{};
  std::string name;
  bool is_dot = false;
};

/// Legend lines of the width of the page; text widths are estimated from the number of letters.
class Legend {
public:
  Legend(const std::vector<LegendEntry>& entries, double page_width, double em) : em_(0.78 * em) {
    double used = 0;
    for (const LegendEntry& entry : entries) {
      const double width = width_of(entry);
      if (lines_.empty() || used + width > page_width) {
        lines_.emplace_back();
        used = 0;
      }
      lines_.back().push_back(entry);
      used += width;
    }
  }
  double height() const { return static_cast<double>(lines_.size()) * line_height * em_; }
  void draw(vtkRenderer& renderer, double middle, double top) const {
    for (const auto& line : lines_) {
      double width = 0;
      for (const LegendEntry& entry : line)
        width += width_of(entry);
      double left = middle - width / 2;
      for (const LegendEntry& entry : line) {
        const double mark = entry.is_dot ? 0.5 * em_ : 0.85 * em_;
        add_rectangle(renderer, {left, top - em_ / 2 - mark / 2, mark, mark}, entry.colour);
        const double text_width = letters(entry) * em_;
        add_text(renderer, entry.name, left + 1.3 * em_ + text_width / 2, top, em_, ink, false);
        left += width_of(entry);
      }
      top -= line_height * em_;
    }
  }

private:
  static constexpr double line_height = 1.6;
  static double letters(const LegendEntry& entry) { return 0.56 * static_cast<double>(entry.name.size()); }
  double width_of(const LegendEntry& entry) const { return (letters(entry) + 2.9) * em_; }

  double em_;
  std::vector<std::vector<LegendEntry>> lines_;
};

std::vector<LegendEntry> legend_of(const Scene& scene, const BodyParts& parts,
                                   const std::vector<Arrow>& arrows) {
  std::vector<LegendEntry> entries;
  constexpr std::size_t most_names = 24;
  for (std::size_t i = 0; i < std::min(parts.names.size(), most_names); ++i)
    entries.push_back({part_colour(i, parts.names.size()), parts.names[i]});
  if (parts.names.size() > most_names)
    entries.push_back({{1, 1, 1}, fmt::format("and {} more", parts.names.size() - most_names)});
  const auto has = [&](bool held) {
    return std::ranges::any_of(scene.prescribed, [=](const Prescribed& one) { return one.held == held; });
  };
  if (has(true))
    entries.push_back({held_colour, "held", true});
  if (has(false))
    entries.push_back({moved_colour, "moved, arrows not to scale", true});
  if (std::ranges::any_of(arrows, [](const Arrow& arrow) { return arrow.colour == loaded_colour; }))
    entries.push_back({loaded_colour, "loaded", true});
  if (!scene.springs.empty())
    entries.push_back({sprung_colour, "on springs", true});
  if (scene.has_fibres() && scene.dimension() > 1) {
    entries.push_back({fibre_colour, "fibres", true});
    if (scene.contracts() || !scene.timed.empty())
      entries.push_back({loaded_colour, "fibres that pull", true});
  }
  return entries;
}

} // namespace

BodyParts parts_of(const Scene& scene) {
  const Specimen& body = scene.specimen;
  const bool has_labels = !body.label.empty();
  std::map<int, std::string> names; // by label or material
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    if (body.is_matter(cell)) {
      const std::string& material = scene.materials[body.material(cell)].name;
      const int key = has_labels ? body.label[cell] : body.material(cell);
      if (!names.contains(key))
        names[key] = has_labels ? fmt::format("{} {}", key, material) : material;
    }
  BodyParts parts;
  std::map<int, int> place;
  for (const auto& [key, name] : names) {
    place[key] = static_cast<int>(parts.names.size());
    parts.names.push_back(name.empty() ? "matter" : name);
  }
  for (std::int64_t cell = 0; cell < body.grid.n_cells(); ++cell)
    parts.of_cell.push_back(
        body.is_matter(cell) ? place.at(has_labels ? body.label[cell] : body.material(cell)) : -1);
  return parts;
}

std::optional<std::string> render_question(const Scene& scene, const std::filesystem::path& png,
                                           const QuestionPictureSettings& settings) {
  const BodyParts parts = parts_of(scene);
  const std::vector<Arrow> arrows = arrows_of(scene, 0.14 * longest_side(scene));
  std::vector<Vec3> ends;
  for (const Arrow& arrow : arrows)
    ends.insert(ends.end(), {arrow.from, arrow.to});
  const View view = choose_view(scene, {}, 1, matter_only(scene.specimen).nodes, ends);
  const PictureSettings size{.width = settings.width, .largest_height = settings.largest_height};
  const double em = settings.width / 62.0;
  const Legend legend(legend_of(scene, parts, arrows), settings.width - 10 * em, em);
  PageParts heights;
  heights.label = 0.5;
  heights.legend = std::max(4.5, legend.height() / em + 1);
  const Page page = choose_page(view, 1, size, heights);
  std::string why_not;
  const auto sheet = Sheet::open(page, view, why_not);
  if (sheet == nullptr)
    return why_not;
  legend.draw(sheet->paper(), page.width / 2.0 + 4 * em, page.legend.bottom + page.legend.height - 0.3 * em);
  add_triad(sheet->paper(), view, scene, settings.is_anatomical, page, em);
  Props props = part_actors(scene, parts, view, page.scale);
  for (const Props& more :
       {fibre_actors(scene, view, page.scale), condition_actors(scene, arrows, view, page.scale)})
    props.insert(props.end(), more.begin(), more.end());
  sheet->draw(0, props);
  sheet->save(png);
  return std::nullopt;
}

} // namespace maille::studies
