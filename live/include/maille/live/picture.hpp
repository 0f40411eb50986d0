#pragma once
/// Pictures of a world's state: request, response, and the rendering loop.

#include "maille/live/session.hpp"
#include "maille/render/renderer.hpp"
#include "maille/render/views.hpp"
#include "maille/scene/look.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace maille::live {

enum class Stereo { none, side_by_side, anaglyph };
enum class ColourBy { look, strain, error, fem };

/// A number per cell of a deformable object, displayed in colours: strain, or a distance between answers.
struct Field {
  int object = -1;
  std::vector<float> of_cells; ///< by cell of the body's grid
  double low = 0, high = 1;
  std::string name, unit; ///< `strain`, ``
};

/// Parameters of a picture. Equal parameters give equal pictures.
struct Looking {
  render::View view; ///< size of the whole picture, camera
  /// For 2D worlds, seen from above: centre [m] and height [m] of the visible area.
  Vec3 middle{};
  double height = 1;
  Stereo stereo = Stereo::none;
  double eye_separation = 0;          ///< [m]; 0: a thirtieth of the distance
  double opacity = 1;                 ///< factor on the opacity of the looks
  double opacity_shift = 0;           ///< shift of the opacity thresholds, relative to their range
  std::shared_ptr<const Field> field; ///< replaces the object's colours
  /// True during motion if only some nodes of a large body are drawn.
  bool is_rough = false;
  std::uint64_t number = 0; ///< changes with look, field or view
};

/// A picture, and the object and depth under each pixel.
struct Painted {
  std::uint64_t number = 0;
  int width = 0, height = 0;
  std::shared_ptr<const std::vector<std::uint8_t>> rgba;
  std::vector<std::int32_t> object; ///< per pixel; -1: background. Stereo pictures: left eye
  std::vector<float> depth;         ///< along the ray [m]; empty for 2D worlds
  Looking looking;
  std::shared_ptr<const WorldState> state;
  std::shared_ptr<const WorldScene> scene;
  double seconds = 0;   ///< rendering time
  bool is_whole = true; ///< false: reduced resolution, during motion

  struct Under {
    int object = -1;
    Vec3 world{}; ///< [m]
    Vec3 rest{};  ///< rest position of that point, in the object's frame [m]
  };
  /// The object at a point. @param x, y relative to the size of the picture, 0 to 1 from the upper left
  /// @param reach  radius for single voxels: without a movable object at the point, the nearest movable pixel
  /// within this distance [pixels] is used
  std::optional<Under> under(double x, double y, double reach = 0) const;
};

/// For 2D worlds: the relative picture position of a world position, from the upper left, and the inverse.
std::array<double, 2> flat_place(const Looking& looking, double aspect, const Vec3& world);
Vec3 flat_point(const Looking& looking, double aspect, double x, double y);
/// The view that shows a whole 2D world of any size. @param aspect width over height
Looking flat_looking(const WorldScene& scene, double aspect);

/// For use by one thread only.
class Painter {
public:
  virtual ~Painter() = default;
  /// Draws a picture. @return all members except number, scene and state
  virtual Painted paint(const WorldScene& scene, const WorldState& state, const Looking& looking) = 0;
};
/// Seen from above, cell by cell. 2D (and 1D) worlds.
std::unique_ptr<Painter> flat_painter();
/// Volume ray casting, for 3D worlds. @param paints replace the looks' colours, one per object or fewer; or
/// null
std::unique_ptr<Painter> volume_painter(std::vector<std::optional<Seen>> looks, int threads,
                                        std::vector<std::shared_ptr<const render::Paint>> paints = {});

/// Renders pictures in its own thread, always of the newest state and view: during motion with a resolution
/// reduced as far as 30 pictures per second require, then at full resolution.
class PainterLoop {
public:
  /// @param has_painted called from that thread
  PainterLoop(std::unique_ptr<Painter> painter, std::function<void()> has_painted);
  ~PainterLoop();

  void look(std::shared_ptr<const WorldScene> scene, std::shared_ptr<const WorldState> state,
            const Looking& looking);
  /// The newest picture; null before the first.
  std::shared_ptr<const Painted> newest() const;
  /// True if the last requested picture is complete, at full resolution.
  bool is_idle() const;
  /// Disables reduced resolution, whatever the time.
  void set_whole_only(bool whole) { whole_only_ = whole; }

private:
  struct Asked;
  void run();
  std::shared_ptr<const Painted> paint(const Asked& asked, double scale);

  std::unique_ptr<Painter> painter_;
  std::function<void()> has_painted_;
  std::atomic<std::shared_ptr<const Asked>> asked_;
  std::atomic<std::shared_ptr<const Painted>> newest_;
  std::atomic<std::uint32_t> bell_{0};
  std::atomic<std::uint64_t> asked_number_{0}, done_number_{0};
  std::atomic<bool> is_stopping_{false}, whole_only_{false};
  double seconds_whole_ = 0; ///< estimated time of a full picture during motion, from recent pictures
  std::uint64_t number_ = 0;
  bool has_coarse_ = false; ///< the data for coarse pictures exist
  std::thread thread_;
};

/// `NAME.png`, without a folder.
bool is_name_of_picture(const std::string& name);
/// Writes a PNG of four bytes per pixel, atomically. Replaces an existing file only if it is no input and no
/// link. @return the reason of a failure; empty: success
/// @return why it could not; empty: it is there
std::string write_png(const std::string& file, int width, int height, const std::vector<std::uint8_t>& rgba,
                      const std::function<void(const std::filesystem::path&)>& finish = {});

} // namespace maille::live
