// Fields of an answer as colours of cells.

#include "maille/scene/cell_fields.hpp"
#include "view/seen_scene.hpp"

#include <algorithm>
#include <cmath>

namespace maille::studies {

namespace {

/// sqrt(2/3 e' : e') of the deviator: what von Mises' stress is to stresses.
double equivalent(const std::array<double, 6>& e) {
  const double mean = (e[0] + e[1] + e[2]) / 3;
  double sum = 0;
  for (std::size_t c = 0; c < 6; ++c)
    sum += (c < 3 ? 1 : 2) * std::pow(e[c] - (c < 3 ? mean : 0), 2);
  return std::sqrt(2.0 / 3 * sum);
}

std::vector<float> values_of(const Scene& scene, const Displacement* displacement, const std::string& field) {
  const Specimen& body = scene.specimen;
  if (displacement != nullptr && (field == "displacement" || field == "error"))
    return lengths_of_cells(body, *displacement);
  if (displacement != nullptr && (field == "strain" || field == "stress")) {
    const CellFields fields = cell_fields(scene, *displacement);
    std::vector<float> values(fields.strain.size());
    for (std::size_t cell = 0; cell < values.size(); ++cell)
      values[cell] =
          static_cast<float>(field == "stress" ? fields.von_mises[cell] : equivalent(fields.strain[cell]));
    return values;
  }
  return {};
}

/// For each cell the one whose colour it has: its own, or, without matter, a neighbour's with it, so that
/// colours go on to the surface.
std::vector<std::int64_t> coloured_by(const Specimen& body) {
  std::vector<std::int64_t> from(body.grid.n_cells());
  for (std::int64_t cell = 0; cell < std::ssize(from); ++cell) {
    from[cell] = cell;
    const Index3 at = body.grid.cell_at(cell);
    int nearest = body.is_matter(cell) ? 0 : 4; // squared distance
    for (int dz = -1; dz <= 1; ++dz)
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          const Index3 other{at[0] + dx, at[1] + dy, at[2] + dz};
          const int distance = dx * dx + dy * dy + dz * dz;
          if (distance >= nearest || !body.grid.has_cell(other) || !body.is_matter(body.grid.cell(other)))
            continue;
          nearest = distance;
          from[cell] = body.grid.cell(other);
        }
  }
  return from;
}

/// Directions as colours: how much they go along x, y and z.
std::shared_ptr<const render::Paint> paint_of_fibres(const Specimen& body) {
  std::vector<std::uint8_t> rgb;
  rgb.reserve(3 * static_cast<std::size_t>(body.grid.n_cells()));
  for (const std::int64_t cell : coloured_by(body)) {
    const Vec3 fibre = body.fibre_of(cell);
    for (const double part : fibre)
      rgb.push_back(static_cast<std::uint8_t>(std::lround(255 * std::min(1.0, std::abs(part)))));
  }
  return render::Paint::picture(render::cells_as_voxels(body), rgb);
}

/// Labels, or materials where the body is no segmentation, in as many colours.
std::shared_ptr<const render::Paint> paint_of_numbers(const Specimen& body) {
  constexpr std::array<Rgb, 8> hues{{{0.75f, 0.25f, 0.20f},
                                     {0.93f, 0.85f, 0.68f},
                                     {0.30f, 0.50f, 0.70f},
                                     {0.45f, 0.62f, 0.32f},
                                     {0.62f, 0.42f, 0.68f},
                                     {0.85f, 0.58f, 0.22f},
                                     {0.32f, 0.62f, 0.60f},
                                     {0.70f, 0.66f, 0.30f}}};
  std::array<Rgb, 256> colours{};
  for (std::size_t i = 0; i < colours.size(); ++i)
    colours[i] = hues[i % hues.size()];
  std::vector<std::uint8_t> numbers;
  for (const std::int64_t cell : coloured_by(body)) {
    const std::size_t c = cell;
    numbers.push_back(!body.label.empty()    ? static_cast<std::uint8_t>(body.label[c] & 255)
                      : body.is_matter(cell) ? body.material(cell)
                                             : std::uint8_t{0});
  }
  return render::Paint::labels(render::cells_as_voxels(body), std::move(numbers), colours);
}

} // namespace

std::shared_ptr<const render::Paint> paint_of_labels(const Specimen& body, const Look& look) {
  std::array<Rgb, 256> colours{};
  constexpr std::size_t most = render::Paint::own_colour; // that many have colours of their own
  std::vector<std::uint8_t> numbers(body.grid.n_cells(), render::Paint::own_colour);
  // The body's own surface lies between its cells and those without matter; grey values do not end there.
  const std::vector<std::int64_t> from = coloured_by(body);
  for (std::size_t l = 0; l < std::min(look.label_colours.size(), most); ++l) {
    colours[l] = look.label_colours[l].second;
    for (std::size_t cell = 0; cell < numbers.size(); ++cell) {
      const auto source = look.of_grey_values ? static_cast<std::int64_t>(cell) : from[cell];
      if (body.is_matter(source) && body.label[source] == look.label_colours[l].first)
        numbers[cell] = static_cast<std::uint8_t>(l);
    }
  }
  return render::Paint::labels(render::cells_as_voxels(body), std::move(numbers), colours, true);
}

std::shared_ptr<const render::Paint> paint_of_field(const Scene& scene, const Displacement* displacement,
                                                    const std::string& field, double& largest) {
  largest = 0;
  if (field == "fibres")
    return paint_of_fibres(scene.specimen);
  if (field == "labels")
    return paint_of_numbers(scene.specimen);
  auto values = values_of(scene, displacement, field);
  if (values.empty())
    return nullptr;
  std::vector<float> of_matter;
  for (std::size_t cell = 0; cell < values.size(); ++cell)
    if (scene.specimen.is_matter(static_cast<std::int64_t>(cell)))
      of_matter.push_back(values[cell]);
  // A few cells at corners of holds have far larger values than all others: they would leave no colours.
  const std::size_t place = of_matter.size() - 1 - of_matter.size() / 100;
  std::ranges::nth_element(of_matter, of_matter.begin() + static_cast<std::ptrdiff_t>(place));
  largest = of_matter[place];
  return render::paint_of_cells(scene.specimen, std::move(values), 0, largest);
}

} // namespace maille::studies
