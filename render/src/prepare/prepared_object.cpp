#include "prepare/prepared_object.hpp"

#include "maille/base/vectors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace maille::render {

namespace {

/// x -> rows x + offset, in double precision.
struct Affine {
  Rows rows{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Vec3 offset{};

  Vec3 operator()(const Vec3& x) const { return plus(times(rows, x), offset); }
  Affine after(const Affine& first) const {
    Affine both;
    for (std::size_t row = 0; row < 3; ++row)
      both.rows[row] = transposed_times(first.rows, rows[row]);
    both.offset = (*this)(first.offset);
    return both;
  }
};

Affine object_from_world(const Pose& pose) {
  Affine map;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column)
      map.rows[row][column] = pose.rotation[column][row];
  map.offset = times(-1, times(map.rows, pose.position));
  return map;
}

Affine index_from_object(const VoxelGrid& grid) {
  Affine map;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column)
      map.rows[row][column] = grid.direction[column][row] / grid.spacing[row];
  map.offset = times(-1, times(map.rows, grid.origin));
  return map;
}

Affine object_from_index(const VoxelGrid& grid) {
  Affine map;
  for (std::size_t row = 0; row < 3; ++row)
    for (std::size_t column = 0; column < 3; ++column)
      map.rows[row][column] = grid.direction[row][column] * grid.spacing[column];
  map.offset = grid.origin;
  return map;
}

Float3 in_floats(const Vec3& x) {
  return {static_cast<float>(x[0]), static_cast<float>(x[1]), static_cast<float>(x[2])};
}

std::array<Float3, 3> in_floats(const Rows& rows) {
  return {in_floats(rows[0]), in_floats(rows[1]), in_floats(rows[2])};
}

/// Rays of a camera in an affine coordinate frame, as a RayFrame.
RayFrame frame_of(const Camera& camera, const Affine& map) {
  const auto [right, up, ahead] = camera.axes();
  RayFrame frame;
  frame.origin = in_floats(map(camera.position));
  frame.ahead = in_floats(times(map.rows, ahead));
  const Float3 to_right = in_floats(times(map.rows, right)), upwards = in_floats(times(map.rows, up));
  (camera.parallel ? frame.origin_right : frame.right) = to_right;
  (camera.parallel ? frame.origin_up : frame.up) = upwards;
  return frame;
}

RayPlane plane_of(const Camera& camera, const Vec3& point, const Vec3& normal) {
  Affine map;
  map.rows = {normal, Vec3{}, Vec3{}};
  map.offset = {-dot(normal, point), 0, 0};
  const RayFrame frame = frame_of(camera, map);
  return {frame.origin[0], frame.origin_right[0], frame.origin_up[0],
          frame.ahead[0],  frame.right[0],        frame.up[0]};
}

std::array<std::int32_t, 3> strides_of(const Index3& size) {
  // Stride 0 along axes with one voxel.
  return {size[0] > 1 ? 1 : 0, size[1] > 1 ? size[0] : 0, size[2] > 1 ? size[0] * size[1] : 0};
}

double smallest(const Vec3& h) {
  return std::min({h[0], h[1], h[2]});
}

/// Pixels of a tile in small squares, so that rays of one block stay together.
const std::array<std::int32_t, tile_pixels>& block_order() {
  static const std::array<std::int32_t, tile_pixels> order = [] {
    const int lanes = lanes_of_cast();
    const int across = lanes >= 8 ? 4 : lanes >= 4 ? 2 : 1, down = std::max(1, lanes / across);
    std::array<std::int32_t, tile_pixels> pixels{};
    std::size_t n = 0;
    for (int y = 0; y < tile_edge; y += down)
      for (int x = 0; x < tile_edge; x += across)
        for (int j = 0; j < down; ++j)
          for (int i = 0; i < across; ++i)
            pixels[n++] = x + i + tile_edge * (y + j);
    return pixels;
  }();
  return order;
}

} // namespace

PreparedObject::PreparedObject(const SceneObject& object, const View& view, int threads,
                               const PreparedObject* before)
    : object_(object), view_(view), step_(smallest(object.volume->grid().spacing) / view.samples_per_voxel),
      tiles_x_(tiles_along(view.width)) {
  const auto lattice_of = [](const SceneObject& of) {
    return of.deformation ? of.deformation->shared_lattice() : nullptr;
  };
  const bool is_same = before != nullptr && before->object_.volume == object.volume &&
                       before->object_.look == object.look && before->step_ == step_ &&
                       lattice_of(before->object_) == lattice_of(object);
  tables_ = is_same ? before->tables_ : make_tables(object, step_, threads);
  set_values();
  set_rays(view);
  set_light(view);
  set_paint();
  if (object.deformation) {
    set_lattice();
    events_.emplace(*object_.deformation, tables_->surface, object_.pose, view, threads);
  } else {
    depths_.emplace(object_.volume->grid(), tables_->boxes, object_.pose, view, threads);
  }
  box_ = box_on(view);
}

std::shared_ptr<const PreparedObject::Tables> PreparedObject::make_tables(const SceneObject& object,
                                                                          double step, int threads) {
  auto tables = std::make_shared<Tables>();
  const Volume& volume = *object.volume;
  tables->transfer = transfer_table(*object.look, volume, step);
  tables->gloss = gloss_table(object.look->shading);
  if (object.deformation) {
    tables->surface =
        surface_of(object.deformation->lattice(), volume, *object.look, tables->transfer, threads);
    tables->is_empty = tables->surface.faces.empty();
    return tables;
  }
  tables->distances = brick_distances(volume, tables->transfer, *object.look);
  tables->boxes = seen_boxes(volume, tables->transfer, *object.look, tables->distances, threads);
  const Index3 n = volume.bricks();
  constexpr int edge = Volume::brick_edge;
  Vec3 low{1e30, 1e30, 1e30}, high{-1e30, -1e30, -1e30};
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i)
        if (tables->distances[i + n[0] * (j + n[1] * k)] == 0) {
          tables->is_empty = false;
          const Vec3 first{1.0 * edge * i, 1.0 * edge * j, 1.0 * edge * k};
          for (std::size_t a = 0; a < 3; ++a) {
            low[a] = std::min(low[a], first[a]);
            high[a] = std::max(high[a], std::min(first[a] + edge, volume.grid().size[a] - 1.0));
          }
        }
  tables->visible = {low, high};
  return tables;
}

void PreparedObject::set_values() {
  const Volume& volume = *object_.volume;
  const Look& look = *object_.look;
  if (volume.depth() == Volume::Depth::bits8)
    task_.codes8 = volume.codes8();
  else
    task_.codes16 = volume.codes16();
  task_.gradients = volume.gradients();
  task_.size = volume.grid().size;
  task_.stride = strides_of(volume.grid().size);
  task_.table_scale = static_cast<float>(TransferTable::size - 1) / static_cast<float>(volume.largest_code());
  task_.mode = look.mode;
  task_.isocode = static_cast<float>((look.isovalue - volume.low()) / (volume.high() - volume.low()) *
                                     volume.largest_code());
  task_.alpha = tables_->transfer.alpha.data();
  const std::vector<std::int32_t>& before = tables_->transfer.visible_before;
  task_.last_unseen = static_cast<std::int32_t>(std::ranges::upper_bound(before, 0) - before.begin()) - 2;
  for (std::size_t a = 0; a < 3; ++a)
    task_.colour[a] = tables_->transfer.colour[a].data();
  task_.surface_alpha = static_cast<float>(std::clamp(look.opacity_at(look.isovalue), 0.0, 1.0));
  task_.step = static_cast<float>(step_);
  if (!object_.deformation) {
    task_.brick_distance = tables_->distances.data();
    task_.brick_stride = {1, volume.bricks()[0], volume.bricks()[0] * volume.bricks()[1]};
  }
}

void PreparedObject::set_rays(const View& view) {
  const Camera& camera = view.camera;
  task_.parallel = camera.parallel;
  const double half = 0.5 * view.height;
  task_.pixel_scale = static_cast<float>(camera.half_height() / half);
  task_.middle_x = static_cast<float>(0.5 * view.width - 0.5);
  task_.middle_y = static_cast<float>(half - 0.5);
  const Affine to_object = object_from_world(object_.pose);
  task_.voxels = frame_of(camera, index_from_object(object_.volume->grid()).after(to_object));
  task_.object = frame_of(camera, to_object);
  for (const ClipPlane& plane : view.clips)
    task_.clips.push_back(plane_of(camera, plane.point, plane.normal));
  if (object_.crop && !object_.deformation)
    for (std::size_t a = 0; a < 3; ++a) {
      const Vec3 axis{object_.pose.rotation[0][a], object_.pose.rotation[1][a], object_.pose.rotation[2][a]};
      task_.clips.push_back(plane_of(camera, object_.pose.to_world(object_.crop->low), axis));
      task_.clips.push_back(plane_of(camera, object_.pose.to_world(object_.crop->high), times(-1, axis)));
    }
  const double distance = length(minus(camera.focal_point, camera.position));
  task_.cue_slope = static_cast<float>(-view.depth_cue / distance);
  task_.cue_offset = static_cast<float>(1 + 0.5 * view.depth_cue);
}

void PreparedObject::set_light(const View& view) {
  const Shading& shading = object_.look->shading;
  // The maximum along a ray has no side to shade.
  task_.shaded = shading.on && object_.volume->has_gradients() && object_.look->mode != LookMode::maximum;
  if (!task_.shaded)
    return;
  task_.ambient = static_cast<float>(shading.ambient);
  task_.diffuse = static_cast<float>(shading.diffuse);
  task_.gloss = tables_->gloss.data();
  task_.cut_scale = static_cast<float>(1 / smallest(object_.volume->grid().spacing));
  const auto [right, up, ahead] = view.camera.axes();
  const Vec3 light =
      unit(plus(plus(times(view.light[0], right), times(view.light[1], up)), times(-view.light[2], ahead)));
  const auto in_axes_of_gradients = [&](const Vec3& world) {
    const Vec3 object = transposed_times(object_.pose.rotation, world);
    return object_.deformation ? object : transposed_times(object_.volume->grid().direction, object);
  };
  task_.light = in_floats(in_axes_of_gradients(light));
  task_.eye = in_floats(in_axes_of_gradients(times(-1, ahead)));
  task_.light_eye = static_cast<float>(-dot(light, ahead));
}

void PreparedObject::set_paint() {
  const Paint* paint = object_.paint.get();
  if (paint == nullptr)
    return;
  if (paint->kind() == Paint::Kind::picture)
    task_.paint_pixels = paint->pixels();
  else
    task_.paint_numbers = paint->numbers();
  task_.palette = paint->palette();
  task_.paint_is_field = paint->kind() == Paint::Kind::field;
  task_.paint_keeps_own = paint->keeps_own();
  task_.paint_size = paint->grid().size;
  task_.paint_stride = strides_of(paint->grid().size);
  const Affine map = index_from_object(paint->grid()).after(object_from_index(object_.volume->grid()));
  task_.paint_rows = in_floats(map.rows);
  task_.paint_offset = in_floats(map.offset);
}

void PreparedObject::set_lattice() {
  const Lattice& lattice = object_.deformation->lattice();
  const VoxelGrid& grid = object_.volume->grid();
  task_.nodes = object_.deformation->nodes().front().data();
  task_.cells = lattice.cells;
  const Index3 n = lattice.nodes();
  task_.node_stride = {1, n[0], n[0] * n[1]};
  Affine from_lattice;
  for (std::size_t a = 0; a < 3; ++a) {
    from_lattice.rows[a][a] = lattice.spacing[a];
    from_lattice.offset[a] = lattice.origin[a];
  }
  const Affine to_voxels = index_from_object(grid).after(from_lattice);
  task_.voxel_rows = in_floats(to_voxels.rows);
  task_.voxel_offset = in_floats(to_voxels.offset);
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 rest{};
    for (std::size_t a = 0; a < 3; ++a)
      rest[a] = ((corner >> a) & 1) != 0 ? lattice.cells[a] + double{lattice_slack} : -double{lattice_slack};
    const Vec3 at = to_voxels(rest);
    for (std::size_t a = 0; a < 3; ++a)
      task_.leaves_voxels = task_.leaves_voxels || at[a] < 0 || at[a] > grid.size[a] - 1;
  }
  for (std::size_t a = 0; a < 3; ++a)
    task_.gradient_rows[a] =
        in_floats(times(lattice.spacing[a] / smallest(lattice.spacing), grid.direction[a]));
  if (object_.crop) {
    task_.has_crop = true;
    for (std::size_t a = 0; a < 3; ++a) {
      task_.crop_low[a] = static_cast<float>((object_.crop->low[a] - lattice.origin[a]) / lattice.spacing[a]);
      task_.crop_high[a] =
          static_cast<float>((object_.crop->high[a] - lattice.origin[a]) / lattice.spacing[a]);
    }
  }
}

PixelBox PreparedObject::box_on(const View& view) const {
  const PixelBox all{0, 0, view.width, view.height};
  if (tables_->is_empty || object_.hidden)
    return {};
  Vec3 low{1e30, 1e30, 1e30}, high{-1e30, -1e30, -1e30};
  bool is_behind = false;
  const auto take = [&](const Vec3& world) {
    const Vec3 at = view.camera.project(view.width, view.height, world);
    is_behind = is_behind || (!view.camera.parallel && at[2] <= 0);
    for (std::size_t a = 0; a < 2; ++a) {
      low[a] = std::min(low[a], at[a]);
      high[a] = std::max(high[a], at[a]);
    }
  };
  if (object_.deformation) // their tiles are found face by face
    return all;
  for (int corner = 0; corner < 8; ++corner) {
    Vec3 index{};
    for (std::size_t a = 0; a < 3; ++a)
      index[a] = ((corner >> a) & 1) != 0 ? tables_->visible.high[a] : tables_->visible.low[a];
    take(object_.pose.to_world(object_.volume->grid().point_of(index)));
  }
  if (is_behind)
    return all;
  const auto clamped = [](double pixel, int n) { return static_cast<int>(std::clamp(pixel, 0.0, 1.0 * n)); };
  return {clamped(std::floor(low[0]), view.width), clamped(std::floor(low[1]), view.height),
          clamped(std::ceil(high[0]) + 1, view.width), clamped(std::ceil(high[1]) + 1, view.height)};
}

std::int64_t PreparedObject::cast_pixels(int tile, std::span<const std::int32_t> in_tile,
                                         const TileStretches* stretches, bool one_by_one,
                                         RunSink& sink) const {
  const std::size_t lanes = lanes_of_cast();
  const int x = tile % tiles_x_ * tile_edge, y = tile / tiles_x_ * tile_edge;
  std::vector<PixelBlock> blocks;
  for (std::size_t first = 0; first < in_tile.size(); first += lanes) {
    PixelBlock& block = blocks.emplace_back();
    block.n = static_cast<int>(std::min(lanes, in_tile.size() - first));
    for (int lane = 0; lane < block.n; ++lane) {
      const std::int32_t pixel = in_tile[first + lane];
      block.in_tile[lane] = pixel;
      block.x[lane] = x + pixel % tile_edge;
      block.y[lane] = y + pixel / tile_edge;
      if (depths_) {
        const BrickDepths::Range& range = depths_->at(block.x[lane], block.y[lane]);
        block.nearest[lane] = range.nearest;
        block.farthest[lane] = range.farthest;
      }
    }
  }
  cast_blocks(task_, blocks, stretches, one_by_one, sink);
  return static_cast<std::int64_t>(in_tile.size());
}

std::int64_t PreparedObject::cast(int tile, RunSink& sink) const {
  std::array<std::int32_t, tile_pixels> pixels{};
  std::size_t n = 0;
  const int x = tile % tiles_x_ * tile_edge, y = tile / tiles_x_ * tile_edge;
  TileStretches stretches;
  if (events_) {
    if (!events_->is_in_tile(tile))
      return 0;
    events_->stretches(tile, stretches);
  }
  const auto meets = [&](int px, int py, std::size_t pixel) {
    if (events_)
      return stretches.first[pixel] < stretches.first[pixel + 1];
    const BrickDepths::Range& range = depths_->at(px, py);
    return range.nearest <= range.farthest;
  };
  for (const std::int32_t pixel : block_order()) {
    const int px = x + pixel % tile_edge, py = y + pixel / tile_edge;
    if (px >= box_.x0 && px < box_.x1 && py >= box_.y0 && py < box_.y1 &&
        meets(px, py, static_cast<std::size_t>(pixel)))
      pixels[n++] = pixel;
  }
  return cast_pixels(tile, std::span(pixels).first(n), events_ ? &stretches : nullptr, false, sink);
}

std::int64_t PreparedObject::cast_one_by_one(int tile, std::span<const std::int32_t> in_tile,
                                             RunSink& sink) const {
  TileStretches stretches;
  if (events_)
    events_->stretches(tile, stretches);
  return cast_pixels(tile, in_tile, events_ ? &stretches : nullptr, true, sink);
}

std::int64_t PreparedObject::bytes() const {
  return static_cast<std::int64_t>(tables_->distances.size() + tables_->boxes.size() * sizeof(SeenBox)) +
         tables_->surface.bytes() + std::int64_t{5} * 4 * TransferTable::size;
}

} // namespace maille::render
