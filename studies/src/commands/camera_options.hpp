#pragma once
/// Camera from command-line options.

#include "cli/commands.hpp"
#include "maille/render/views.hpp"

#include <span>

namespace maille::studies {

/// The requested view; without a camera, a view of all objects.
/// @throws UsageError for invalid numbers, too few of them, or a zero viewing direction
render::View view_of(const CameraOptions& options, std::span<const render::SceneObject> objects);
/// The box of `--crop`, for all objects.
std::optional<render::CropBox> crop_of(const CameraOptions& options);
/// @throws UsageError
Rgb background_of(const CameraOptions& options);
/// Combines two pictures to a stereo picture. @param stereo  side_by_side or anaglyph
render::Picture for_two_eyes(const std::string& stereo, const render::Picture& left,
                             const render::Picture& right, const Rgb& background);
/// @throws UsageError if the eye is inside a visible object
void check_eye(const render::View& view, std::span<const render::SceneObject> objects);

} // namespace maille::studies
