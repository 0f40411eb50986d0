#pragma once
/// Scenes and worlds as render takes them: volumes of their looks, poses, deformations, fields.

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

/// Everything of a scene or a world that can be seen, as it stands at first.
///
/// Bodies without a look are shown as their own matter, in one colour each.
struct SeenScene {
  std::string name, title;
  std::vector<render::SceneObject> objects;
  /// Of deformable objects: what their pictures are moved by; null for others.
  std::vector<std::shared_ptr<render::Deformation>> deformations;

  /// Bytes of volumes, paint and deformations.
  std::int64_t bytes() const;
};

/// @param is_deformed the body is to follow an answer
SeenScene seen_scene(const Scene& scene, const std::filesystem::path& file, bool is_deformed);
/// The same by what read_looks has read.
SeenScene seen_scene(const Scene& scene, std::vector<std::optional<Seen>> looks, bool is_deformed);
SeenScene seen_world(const WorldScene& world, const std::filesystem::path& file);
/// Brings poses and deformations of `seen` to those of the world.
void follow(const deform::World& world, SeenScene& seen);
/// The body as an answer's displacement has it.
void follow(const Scene& scene, const Displacement& displacement, SeenScene& seen);

/// The picture of a body's look on its cells. @pre look.picture is not empty
/// @throws InputError where it cannot be read, or does not reach over all of the body
std::shared_ptr<const render::Paint> paint_of_picture(const Specimen& body, const Look& look);

/// Cells of matter in the colours that a look has for their labels; all others keep the look's own.
std::shared_ptr<const render::Paint> paint_of_labels(const Specimen& body, const Look& look);
/// Either, as the look has it; or null.
std::shared_ptr<const render::Paint> paint_of_look(const Specimen& body, const Look& look);

/// Paint by a field of an answer's cells: `displacement`, `strain` (equivalent), `stress` (von Mises),
/// `labels`, `fibres`; from 0 to the largest. @return null if the field is empty
/// @param largest  of the values, in SI units
std::shared_ptr<const render::Paint> paint_of_field(const Scene& scene, const Displacement* displacement,
                                                    const std::string& field, double& largest);

/// Draws the bodies of comparisons by their grey values. @return nothing where the scene's look is not of any
/// @throws InputError as read_looks does
DrawBody draw_grey_values(const Scene& scene, const std::filesystem::path& file, int threads);

/// Writes three bytes a pixel, rows from the top. @throws std::runtime_error
void write_png(const std::vector<std::uint8_t>& rgb, int width, int height,
               const std::filesystem::path& file);

} // namespace maille::studies
