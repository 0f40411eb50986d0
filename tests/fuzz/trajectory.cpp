/// Trajectories, as TOML and, where they begin with the names of columns, as tables, for a world of a rigid
/// and a deformable object.

#include "maille/scene/world/trajectory.hpp"
#include "fuzzing.hpp"
#include "maille/scene/world/world_scene.hpp"

#include <cmath>

namespace maille::fuzzing {
namespace {

bool is_finite(const Vec3& v) {
  return std::isfinite(v[0]) && std::isfinite(v[1]) && std::isfinite(v[2]);
}

void check_trajectory(const Trajectory& path, const WorldScene& world) {
  require(std::isfinite(path.frame_seconds) && path.frame_seconds > 0, "frames that take time");
  for (const DriveSpan& span : path.spans) {
    require(span.object < world.objects.size(), "drives of objects that there are");
    const WorldObject& object = world.objects[span.object];
    require(object.kind != ObjectKind::fixed, "drives of what can move");
    for (const std::int64_t node : span.nodes)
      require(node >= 0 && node < object.scene.specimen.grid.n_nodes(), "nodes that there are");
    require(span.first_frame >= 1 && span.n_frames >= 1 && span.end_frame() - 1 <= path.n_frames,
            "frames that there are");
    require(is_finite(span.by) && (!span.to || is_finite(*span.to)) && is_finite(span.axis) &&
                std::isfinite(span.angle) && (!span.about || is_finite(*span.about)),
            "movements that are finite");
  }
}

} // namespace
} // namespace maille::fuzzing

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace maille;
  static const WorldScene world = read_world_scene(fuzzing::fixtures() / "world.toml");
  const std::string_view text = fuzzing::text_of(data, size);
  const bool is_table = text.starts_with("frame,");
  return fuzzing::tried([&] {
    fuzzing::check_trajectory(parse_trajectory(text, is_table ? "path.csv" : "path.toml", world), world);
  });
}
