#include "maille/render/renderer.hpp"
#include "maille/base/vectors.hpp"

#include "compose/compose.hpp"
#include "prepare/prepared_object.hpp"
#include "prepare/request.hpp"

#include <algorithm>
#include <array>
#include <utility>

namespace maille::render {

Vec3 Pose::to_world(const Vec3& point) const {
  return plus(position, times(rotation, point));
}

Vec3 Pose::to_object(const Vec3& point) const {
  return transposed_times(rotation, minus(point, position));
}

namespace {

/// Compares the inputs of a cast object besides the view.
bool is_same(const SceneObject& a, const SceneObject& b) {
  return a.volume == b.volume && a.look == b.look && a.pose == b.pose && a.deformation == b.deformation &&
         a.paint == b.paint && a.crop == b.crop && a.hidden == b.hidden;
}

} // namespace

struct Renderer::Parts {
  struct Kept {
    SceneObject object;
    std::uint64_t version = 0;
    std::unique_ptr<PreparedObject> prepared;
    std::vector<TileRuns> tiles;
  };
  int threads = 1;
  View view;
  bool has_view = false;
  std::vector<Kept> kept;
  Picture picture;
  Counters counters;
  std::vector<std::uint8_t> is_dirty; ///< per tile

  void look_from(const View& from) {
    if (has_view && view == from)
      return;
    // All tiles are merged anew, so pixels of a picture of equal size need no clearing.
    if (!has_view || view.width != from.width || view.height != from.height)
      clear(picture, from.width, from.height);
    view = from;
    has_view = true;
    for (Kept& object : kept) {
      for (TileRuns& tile : object.tiles) { // keeps their memory, which is reused at once
        tile.first.clear();
        tile.runs.clear();
      }
      object.object.hidden = true; // differs from the request
      object.object.volume = nullptr;
    }
    is_dirty.assign(static_cast<std::size_t>(tiles_along(view.width)) *
                        static_cast<std::size_t>(tiles_along(view.height)),
                    1);
  }

  void mark(const Kept& object) {
    for (std::size_t tile = 0; tile < object.tiles.size(); ++tile)
      if (!object.tiles[tile].empty())
        is_dirty[tile] = 1;
  }

  void cast(Kept& kept_object, const SceneObject& object) {
    mark(kept_object);
    // A hidden object keeps only its tables.
    auto prepared = std::make_unique<PreparedObject>(object, view, threads, kept_object.prepared.get());
    kept_object.object = object;
    kept_object.version = object.deformation ? object.deformation->version() : 0;
    kept_object.prepared = std::move(prepared);
    counters.rays += cast_tiles(*kept_object.prepared, view, threads, kept_object.tiles);
    ++counters.objects;
    mark(kept_object);
  }

  void compose() {
    std::vector<int> tiles;
    for (std::size_t tile = 0; tile < is_dirty.size(); ++tile)
      if (is_dirty[tile] != 0)
        tiles.push_back(static_cast<int>(tile));
    const auto layers_of = [&](int item) {
      const int tile = tiles[item];
      TileLayers of{tile, {}};
      for (std::size_t o = 0; o < kept.size(); ++o)
        if (!kept[o].tiles.empty() && !kept[o].tiles[tile].empty())
          of.second.push_back({static_cast<std::int32_t>(o), &kept[o].tiles[tile], kept[o].prepared.get()});
      return of;
    };
    compose_tiles(static_cast<int>(tiles.size()), layers_of, threads, picture, counters);
    std::ranges::fill(is_dirty, std::uint8_t{0});
  }
};

Renderer::Renderer(int threads) : parts_(std::make_unique<Parts>()) {
  parts_->threads = std::max(1, threads);
}
Renderer::~Renderer() = default;
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;

const Picture& Renderer::render(std::span<const SceneObject> objects, const View& view) {
  check_request(objects, view);
  Parts& parts = *parts_;
  parts.look_from(view);
  for (std::size_t o = objects.size(); o < parts.kept.size(); ++o)
    parts.mark(parts.kept[o]);
  parts.kept.resize(objects.size());
  for (std::size_t o = 0; o < objects.size(); ++o) {
    Parts::Kept& kept = parts.kept[o];
    const std::uint64_t version = objects[o].deformation ? objects[o].deformation->version() : 0;
    if (!kept.object.volume || !is_same(kept.object, objects[o]) || kept.version != version)
      parts.cast(kept, objects[o]);
  }
  parts.compose();
  return parts.picture;
}

const Counters& Renderer::counters() const {
  return parts_->counters;
}

std::int64_t Renderer::bytes() const {
  std::int64_t bytes = static_cast<std::int64_t>(
      parts_->picture.rgba.size() * (sizeof(std::array<float, 4>) + sizeof(float) + sizeof(std::int32_t)));
  for (const Parts::Kept& kept : parts_->kept) {
    for (const TileRuns& tile : kept.tiles)
      bytes += tile.bytes() + static_cast<std::int64_t>(sizeof(TileRuns));
    bytes += kept.prepared ? kept.prepared->bytes() : 0;
  }
  return bytes;
}

std::optional<CropBox> bounds_of(const SceneObject& object) {
  if (object.hidden || !object.volume)
    return std::nullopt;
  CropBox box{{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}};
  const auto take = [&](const Vec3& point) {
    const Vec3 at = object.pose.to_world(point);
    for (std::size_t a = 0; a < 3; ++a) {
      box.low[a] = std::min(box.low[a], at[a]);
      box.high[a] = std::max(box.high[a], at[a]);
    }
  };
  if (object.deformation) {
    for (std::int64_t node = 0; node < object.deformation->lattice().n_nodes(); ++node)
      take(object.deformation->position(node));
    return box;
  }
  const VoxelGrid& grid = object.volume->grid();
  for (int corner = 0; corner < 8; ++corner)
    take(grid.point_of({(corner & 1) != 0 ? grid.size[0] - 1.0 : 0.0,
                        (corner & 2) != 0 ? grid.size[1] - 1.0 : 0.0,
                        (corner & 4) != 0 ? grid.size[2] - 1.0 : 0.0}));
  return box;
}

namespace {

std::uint8_t byte_of(float colour, float alpha, float background) {
  const float value = std::clamp(colour + (1 - alpha) * background, 0.0f, 1.0f);
  return static_cast<std::uint8_t>(value * 255 + 0.5f);
}

} // namespace

std::vector<std::uint8_t> Picture::rgb8(const Rgb& background) const {
  std::vector<std::uint8_t> bytes(3 * rgba.size());
  for (std::size_t p = 0; p < rgba.size(); ++p)
    for (std::size_t c = 0; c < 3; ++c)
      bytes[3 * p + c] = byte_of(rgba[p][c], rgba[p][3], background[c]);
  return bytes;
}

void Picture::rgba8(const Rgb& background, std::uint8_t* out) const {
  for (std::size_t p = 0; p < rgba.size(); ++p, out += 4) {
    for (std::size_t c = 0; c < 3; ++c)
      out[c] = byte_of(rgba[p][c], rgba[p][3], background[c]);
    out[3] = 255;
  }
}

} // namespace maille::render
