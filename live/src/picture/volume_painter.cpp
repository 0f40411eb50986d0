/// 3D worlds, by volume ray casting.

#include "maille/live/picture.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace maille::live {

namespace {

/// Colours of objects without a look, in turn; fixed objects have the colour of bone.
constexpr std::array<Rgb, 6> colours{{{0.80f, 0.36f, 0.30f},
                                      {0.42f, 0.58f, 0.78f},
                                      {0.88f, 0.72f, 0.36f},
                                      {0.46f, 0.66f, 0.44f},
                                      {0.66f, 0.50f, 0.74f},
                                      {0.40f, 0.70f, 0.70f}}};
constexpr Rgb bone{0.88f, 0.85f, 0.78f};
constexpr Rgb background{1, 1, 1};
/// Samples along rays during motion, relative to a full picture.
constexpr double rough_samples = 0.5;

/// Look of a thin body: a smooth surface around one or two voxels has little volume, so its threshold is
/// lowered.
Look solid(const Rgb& colour, const Specimen& body) {
  const Index3& n = body.grid.cells();
  const bool is_thin = *std::min_element(n.begin(), n.begin() + body.grid.dimension()) <= 2;
  Look look;
  look.colours = {{0, colour}};
  look.opacity = is_thin ? std::vector<OpacityPoint>{{0.15, 0}, {0.25, 0.95}}
                         : std::vector<OpacityPoint>{{0.40, 0}, {0.55, 0.95}};
  return look;
}

render::Pose pose_of(const deform::Pose& frame) {
  render::Pose pose;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      pose.rotation[row][column] = frame.rotation(row, column);
  pose.position = {frame.position[0], frame.position[1], frame.position[2]};
  return pose;
}

/// Stride between the drawn nodes along an axis during motion.
int stride_of(const Grid& grid) {
  constexpr std::int64_t few = 60'000;
  int stride = 1;
  while (grid.n_nodes() / (std::int64_t{stride} * stride * stride) > few)
    ++stride;
  return stride;
}

/// Compares owners, because a new state may reuse the memory of an old one.
bool is_same(const std::shared_ptr<const Displacement>& one, const std::weak_ptr<const Displacement>& other) {
  return !one.owner_before(other) && !other.owner_before(one);
}

class VolumePainter : public Painter {
public:
  VolumePainter(std::vector<std::optional<Seen>> looks, int threads,
                std::vector<std::shared_ptr<const render::Paint>> paints)
      : looks_(std::move(looks)),
        paints_(std::move(paints)), whole_{render::Renderer(threads), render::StereoRenderer(threads), {}},
        rough_{render::Renderer(threads), render::StereoRenderer(threads), {}} {}

  Painted paint(const WorldScene& scene, const WorldState& state, const Looking& looking) override {
    if (state.scene_number != scene_number_) {
      make_objects(scene);
      scene_number_ = state.scene_number;
    }
    follow(scene, state, looking);
    Painted painted;
    Seeing& seeing = looking.is_rough ? rough_ : whole_;
    render::View view = looking.view;
    if (looking.is_rough)
      view.samples_per_voxel *= rough_samples;
    if (looking.stereo == Stereo::none) {
      take(seeing.renderer.render(seeing.objects, view), painted);
      return painted;
    }
    if (looking.stereo == Stereo::side_by_side)
      view.width = std::max(1, view.width / 2);
    const auto [left, right] = seeing.eyes.render(seeing.objects, view, {looking.eye_separation});
    const render::Picture both = looking.stereo == Stereo::side_by_side ? render::side_by_side(*left, *right)
                                                                        : render::anaglyph(*left, *right);
    take(both, painted);
    painted.object = left->object;
    painted.depth = left->depth;
    return painted;
  }

private:
  /// Data for pictures during motion and at rest, with separate tables.
  struct Seeing {
    render::Renderer renderer;
    render::StereoRenderer eyes;
    std::vector<render::SceneObject> objects;
  };
  struct Kept {
    Look look;
    std::shared_ptr<render::Deformation> deformation, rough; ///< `rough`: for bodies of many nodes
    std::unique_ptr<render::CoarseCarrier> carrier;
    std::weak_ptr<const Displacement> shown, shown_rough; ///< states of the deformations; not owned
    std::shared_ptr<const Field> field;
  };

  void make_objects(const WorldScene& scene) {
    std::vector<render::SceneObject>& objects = whole_.objects;
    objects.clear();
    kept_.clear();
    std::size_t colour = 0;
    for (std::size_t i = 0; i < scene.objects.size(); ++i) {
      const WorldObject& object = scene.objects[i];
      const Specimen& body = object.scene.specimen;
      render::SceneObject& seen = objects.emplace_back();
      Kept& kept = kept_.emplace_back();
      const bool has_look = i < looks_.size() && looks_[i];
      kept.look = has_look                           ? looks_[i]->look
                  : object.kind == ObjectKind::fixed ? solid(bone, body)
                                                     : solid(colours[colour++ % colours.size()], body);
      seen.paint = own_paint(i);
      seen.volume = has_look ? render::volume_of(*looks_[i], body) : render::volume_of_matter(body);
      if (object.kind == ObjectKind::deformable) {
        kept.deformation = std::make_shared<render::Deformation>(render::lattice_of(body));
        seen.deformation = kept.deformation;
        if (const int stride = stride_of(body.grid); stride > 1) {
          kept.carrier = std::make_unique<render::CoarseCarrier>(body, stride);
          kept.rough = std::make_shared<render::Deformation>(kept.carrier->lattice());
        }
      }
    }
    rough_.objects = objects;
    for (std::size_t i = 0; i < objects.size(); ++i)
      if (kept_[i].rough)
        rough_.objects[i].deformation = kept_[i].rough;
    opacity_ = -1;
  }

  void follow(const WorldScene& scene, const WorldState& state, const Looking& looking) {
    std::vector<render::SceneObject>& objects = whole_.objects;
    for (std::size_t i = 0; i < objects.size() && i < state.frames.size(); ++i) {
      objects[i].pose = rough_.objects[i].pose = pose_of(state.frames[i]);
      Kept& kept = kept_[i];
      if (looking.is_rough && kept.rough) {
        if (state.displacements[i] && !is_same(state.displacements[i], kept.shown_rough))
          kept.carrier->carry(*state.displacements[i], *kept.rough);
        kept.shown_rough = state.displacements[i];
      } else if (kept.deformation && state.displacements[i] && !is_same(state.displacements[i], kept.shown)) {
        render::carry_along(scene.objects[i].scene.specimen, *state.displacements[i], *kept.deformation);
        kept.shown = state.displacements[i];
      }
      const auto n_cells = static_cast<std::size_t>(scene.objects[i].scene.specimen.grid.n_cells());
      const bool has_field = looking.field && looking.field->object == static_cast<int>(i) &&
                             looking.field->of_cells.size() == n_cells;
      const std::shared_ptr<const Field> field = has_field ? looking.field : nullptr;
      if (field != kept.field) {
        objects[i].paint = field ? render::paint_of_cells(scene.objects[i].scene.specimen, field->of_cells,
                                                          field->low, field->high)
                                 : own_paint(i);
        rough_.objects[i].paint = objects[i].paint;
        kept.field = field;
      }
    }
    if (looking.opacity == opacity_ && looking.opacity_shift == shift_)
      return;
    opacity_ = looking.opacity;
    shift_ = looking.opacity_shift;
    for (std::size_t i = 0; i < objects.size(); ++i)
      objects[i].look = rough_.objects[i].look = std::make_shared<const Look>(changed(kept_[i].look));
  }

  std::shared_ptr<const render::Paint> own_paint(std::size_t object) const {
    return object < paints_.size() ? paints_[object] : nullptr;
  }

  Look changed(Look look) const {
    if (look.opacity.empty())
      return look;
    const double range = look.opacity.back().value - look.opacity.front().value;
    for (OpacityPoint& point : look.opacity) {
      point.opacity = std::clamp(opacity_ * point.opacity, 0.0, 1.0);
      point.value += shift_ * range;
    }
    return look;
  }

  static void take(const render::Picture& picture, Painted& painted) {
    painted.width = picture.width;
    painted.height = picture.height;
    auto rgba = std::make_shared<std::vector<std::uint8_t>>(std::size_t{4} * picture.width *
                                                            static_cast<std::size_t>(picture.height));
    picture.rgba8(background, rgba->data());
    painted.rgba = std::move(rgba);
    painted.object = picture.object;
    painted.depth = picture.depth;
  }

  std::vector<std::optional<Seen>> looks_;
  std::vector<std::shared_ptr<const render::Paint>> paints_;
  Seeing whole_, rough_;
  std::vector<Kept> kept_;
  std::uint64_t scene_number_ = 0;
  double opacity_ = -1, shift_ = 0;
};

} // namespace

std::unique_ptr<Painter> volume_painter(std::vector<std::optional<Seen>> looks, int threads,
                                        std::vector<std::shared_ptr<const render::Paint>> paints) {
  return std::make_unique<VolumePainter>(std::move(looks), threads, std::move(paints));
}

} // namespace maille::live
