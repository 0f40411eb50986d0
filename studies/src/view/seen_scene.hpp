#pragma once
/// Conversion of scenes and worlds for render: volumes with their looks, poses, deformations, fields.

#include "maille/deform/world/world.hpp"
#include "maille/render/views.hpp"
#include "maille/scene/look.hpp"
#include "picture/comparison_picture.hpp"

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace maille::studies {

/// All visible objects of a scene or world, in its initial state.
///
/// Bodies without a look are shown by their cells, in one colour each.
struct SeenScene {
  std::string name, title;
  std::vector<render::SceneObject> objects;
  /// Deformations of deformable objects; null for others.
  std::vector<std::shared_ptr<render::Deformation>> deformations;

  /// Bytes of volumes, paint and deformations.
  std::int64_t bytes() const;
};

/// @param is_deformed the body will follow an answer
SeenScene seen_scene(const Scene& scene, const std::filesystem::path& file, bool is_deformed);
/// The same with looks from read_looks.
SeenScene seen_scene(const Scene& scene, std::vector<std::optional<Seen>> looks, bool is_deformed);
SeenScene seen_world(const WorldScene& world, const std::filesystem::path& file);
/// Updates poses and deformations of `seen` from the world.
void follow(const deform::World& world, SeenScene& seen);
/// Deforms the body by an answer's displacement.
void follow(const Scene& scene, const Displacement& displacement, SeenScene& seen);

/// Paint from the picture of a body's look. @pre look.picture is not empty
/// @throws InputError if it cannot be read, or does not cover the whole body
std::shared_ptr<const render::Paint> paint_of_picture(const Specimen& body, const Look& look);

/// Paint of cells in the look's label colours; others keep the look's own colour.
std::shared_ptr<const render::Paint> paint_of_labels(const Specimen& body, const Look& look);
/// Paint from picture or labels, depending on the look; or null.
std::shared_ptr<const render::Paint> paint_of_look(const Specimen& body, const Look& look);

/// Paint by a cell field of an answer: `displacement`, `strain` (equivalent), `stress` (von Mises), `labels`,
/// `fibres`; from 0 to the largest value. @return null if the field is empty
/// @param largest  receives the largest value, in SI units
std::shared_ptr<const render::Paint> paint_of_field(const Scene& scene, const Displacement* displacement,
                                                    const std::string& field, double& largest);

/// Function that draws bodies of comparisons by grey values. @return empty if the look has no grey values
/// @throws InputError as read_looks does
DrawBody draw_grey_values(const Scene& scene, const std::filesystem::path& file, int threads);

/// Writes a PNG of three bytes per pixel, rows from the top. @throws std::runtime_error
void write_png(const std::vector<std::uint8_t>& rgb, int width, int height,
               const std::filesystem::path& file);

} // namespace maille::studies
