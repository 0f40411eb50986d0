#pragma once
/// How an object is to be seen: which grey values, in which colours, how opaque, how lit.
///
/// A look is read from `look = { ... }` of a specimen or an object (docs/render.md), apart from the question
/// that methods are asked: who does not look at a scene keeps no grey value of it.

#include "maille/images/image.hpp"
#include "maille/scene/scene.hpp"

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace maille {

/// Red, green and blue from 0 to 1, as on the screen.
using Rgb = std::array<float, 3>;

/// Colour at one value; between two of them colours are interpolated, outside the nearest holds.
struct ColourPoint {
  double value = 0;
  Rgb colour{1, 1, 1};
  friend bool operator==(const ColourPoint&, const ColourPoint&) = default;
};

/// Opacity, 0 to 1, that `Look::unit_distance` of matter of one value has.
struct OpacityPoint {
  double value = 0;
  double opacity = 0;
  friend bool operator==(const OpacityPoint&, const OpacityPoint&) = default;
};

/// composite: colours and opacities along the ray; maximum: the largest value on it; isosurface: where it
/// first reaches a value.
enum class LookMode { composite, maximum, isosurface };

/// Light of a look: parts of a surface's colour that are there in the dark, that facing the light adds, and
/// that is mirrored.
struct Shading {
  bool on = true;
  double ambient = 0.25, diffuse = 0.75, specular = 0.2;
  double shininess = 20; ///< exponent of the mirrored part, > 0
  friend bool operator==(const Shading&, const Shading&) = default;
};

struct Look {
  std::string image; ///< file of the grey values; empty: of the body's own image, if it has one
  /// Its middle is put on that of the body's own image, whatever the headers say of their places.
  bool is_centred = false;
  std::vector<ColourPoint> colours;  ///< ascending, at least one
  std::vector<OpacityPoint> opacity; ///< ascending, at least one
  /// Colours of cells by label, in place of `colours`; sorted by label.
  std::vector<std::pair<std::int32_t, Rgb>> label_colours;
  /// A colour picture (PNG, JPEG) whose pixels colour the cells that lie under them, along z: its lower left
  /// corner is at the origin of the body's frame. Empty: none.
  std::string picture;
  double pixel = 0;         ///< edge of the picture's pixels [m]; 0: of a cell
  double unit_distance = 0; ///< [m]; 0: a voxel's smallest spacing
  Shading shading;
  LookMode mode = LookMode::composite;
  double isovalue = 0;         ///< of mode isosurface
  bool of_grey_values = false; ///< of an image's; else of the body's own matter, whose values are 0 to 1
  /// How far around the body's matter its image is seen [m]: skin around a muscle. Unset: all of the image
  /// where the object keeps its form, a cell where it is deformable.
  std::optional<double> around;
  friend bool operator==(const Look&, const Look&) = default;

  Rgb colour_at(double value) const;
  double opacity_at(double value) const; ///< of unit_distance
  /// Values at which opacity is above 0 begin and end; nothing where none is.
  std::optional<std::pair<double, double>> visible_range() const;
};

/// A look that comes along. @pre name is a word of look.preset in scene/keys.toml. Values of CT presets are
/// Hounsfield units + 1024, those of others from 0 to 1, to be stretched over a window; see docs/render.md
Look look_preset(std::string_view name);
/// True if its values are from 0 to 1, so that it needs a window.
bool is_relative_preset(std::string_view name);
/// Values from 0 to 1 become those of a window, in colours, opacity and isovalue. @pre low < high
void stretch(Look& look, double low, double high);
/// Matter in one colour: where there are no grey values.
Look solid_look(const Rgb& colour = {0.80f, 0.78f, 0.74f});

/// A colour map of ParaView (.json: a list of maps, of which the first counts): RGBPoints and, where it has
/// them, Points of opacity. @throws InputError
Look read_paraview_colours(const std::filesystem::path& file);

/// Parses `#rrggbb`; nothing for another text.
std::optional<Rgb> parse_colour(std::string_view text);

/// The grey values that a look shows.
struct Seen {
  Look look;
  /// The image, cropped to the visible voxels and a margin of one; components 1. Without values, the look
  /// shows the cells of the body.
  Image grey;
  Placement placement;           ///< of the body's frame in the image's world
  double largest = 0, least = 0; ///< of the whole image's values

  /// Held by the grey values.
  std::int64_t bytes() const { return static_cast<std::int64_t>(grey.values.size() * sizeof(float)); }
};

/// What is to be seen of every body of a scene file: one entry for a scene, one an object for a world, empty
/// where there is no look.
/// @throws InputError with every fault of the looks (file, line, key, expected, found): a look for values
///         that its image does not have, tables out of order, images larger than memory
std::vector<std::optional<Seen>> read_looks(const std::filesystem::path& scene_file);
/// True for the file of a scene whose specimen has a look; reads no image. False for what is no such file.
bool has_look(const std::filesystem::path& file);

} // namespace maille
