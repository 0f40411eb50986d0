#pragma once
/// Appearance of an object: its grey values, colours, opacity and lighting.
///
/// A look is read from `look = { ... }` of a specimen or an object (docs/render.md), separately from the
/// scene that methods solve: a scene that is not displayed stores no grey values.

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

/// Colour at one value; interpolated between points, constant beyond them.
struct ColourPoint {
  double value = 0;
  Rgb colour{1, 1, 1};
  friend bool operator==(const ColourPoint&, const ColourPoint&) = default;
};

/// Opacity, 0 to 1, of a layer of matter of this value, `Look::unit_distance` thick.
struct OpacityPoint {
  double value = 0;
  double opacity = 0;
  friend bool operator==(const OpacityPoint&, const OpacityPoint&) = default;
};

/// composite: colours and opacities along the ray; maximum: the largest value on the ray; isosurface: the
/// first point on the ray that reaches a value.
enum class LookMode { composite, maximum, isosurface };

/// Lighting of a look: parts of a surface's colour that are ambient, diffuse (facing the light) and specular.
struct Shading {
  bool on = true;
  double ambient = 0.25, diffuse = 0.75, specular = 0.2;
  double shininess = 20; ///< exponent of the mirrored part, > 0
  friend bool operator==(const Shading&, const Shading&) = default;
};

struct Look {
  std::string image; ///< file of the grey values; empty: of the body's own image, if it has one
  /// True: place its centre on the centre of the body's own image and ignore the positions in the headers.
  bool is_centred = false;
  std::vector<ColourPoint> colours;  ///< ascending, at least one
  std::vector<OpacityPoint> opacity; ///< ascending, at least one
  /// Colours of cells by label, in place of `colours`; sorted by label.
  std::vector<std::pair<std::int32_t, Rgb>> label_colours;
  /// A colour picture (PNG, JPEG) whose pixels colour the cells under them, along z; its lower left corner is
  /// at the origin of the body's frame. Empty: none.
  std::string picture;
  double pixel = 0;         ///< edge of the picture's pixels [m]; 0: of a cell
  double unit_distance = 0; ///< [m]; 0: a voxel's smallest spacing
  Shading shading;
  LookMode mode = LookMode::composite;
  double isovalue = 0;         ///< of mode isosurface
  bool of_grey_values = false; ///< true: values of an image; false: values of the body's matter, 0 to 1
  /// Distance around the body's matter up to which its image is visible [m], e.g. skin around a muscle.
  /// Unset: the whole image for fixed and rigid objects, one cell for deformable ones.
  std::optional<double> around;
  friend bool operator==(const Look&, const Look&) = default;

  Rgb colour_at(double value) const;
  double opacity_at(double value) const; ///< of unit_distance
  /// Range of values with opacity above 0; nothing if there are none.
  std::optional<std::pair<double, double>> visible_range() const;
};

/// A built-in look. @pre name is a word of look.preset in scene/keys.toml. Values of CT presets are
/// Hounsfield units + 1024; those of others are 0 to 1, for stretch() to a window; see docs/render.md
Look look_preset(std::string_view name);
/// True if its values are from 0 to 1 and it needs a window.
bool is_relative_preset(std::string_view name);
/// Maps values from 0 to 1 to a window, in colours, opacity and isovalue. @pre low < high
void stretch(Look& look, double low, double high);
/// Matter in one colour, for bodies without grey values.
Look solid_look(const Rgb& colour = {0.80f, 0.78f, 0.74f});

/// A colour map of ParaView (.json: a list of maps; the first is used): RGBPoints and, if present, opacity
/// Points. @throws InputError
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

  /// Memory of the grey values [bytes].
  std::int64_t bytes() const { return static_cast<std::int64_t>(grey.values.size() * sizeof(float)); }
};

/// Grey values of every body of a scene file: one entry for a scene, one per object for a world, empty for
/// bodies without a look.
/// @throws InputError with every fault of the looks (file, line, key, expected, found): a look for values
///         that its image lacks, tables out of order, images larger than memory
std::vector<std::optional<Seen>> read_looks(const std::filesystem::path& scene_file);
/// True if the file is a scene whose specimen has a look; reads no image. False for other files.
bool has_look(const std::filesystem::path& file);

} // namespace maille
