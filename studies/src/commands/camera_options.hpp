#pragma once
/// A camera as the words of a command line have it.

#include "cli/commands.hpp"
#include "maille/render/views.hpp"

#include <span>

namespace maille::studies {

/// The view that is asked for; where no camera is given, one that sees all objects.
/// @throws UsageError for what is no number, too few of them, a camera that looks nowhere
render::View view_of(const CameraOptions& options, std::span<const render::SceneObject> objects);
/// The box of `--crop`, for all objects.
std::optional<render::CropBox> crop_of(const CameraOptions& options);
/// @throws UsageError
Rgb background_of(const CameraOptions& options);
/// The picture for two eyes. @param stereo  side_by_side or anaglyph
render::Picture for_two_eyes(const std::string& stereo, const render::Picture& left,
                             const render::Picture& right, const Rgb& background);
/// @throws UsageError where the eye is inside of something that is seen
void check_eye(const render::View& view, std::span<const render::SceneObject> objects);

} // namespace maille::studies
