#pragma once
/// Pictures of a world's state: what is asked, what comes, and the loop that makes them.

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

/// A number at each cell of a deformable object, to be seen in colours: strain, or a distance between
/// answers.
struct Field {
  int object = -1;
  std::vector<float> of_cells; ///< of the body's grid
  double low = 0, high = 1;
  std::string name, unit; ///< `strain`, ``
};

/// How the world is looked at. Whatever is the same gives the same picture.
struct Looking {
  render::View view; ///< size of the whole picture, camera
  /// For 2D worlds, seen from above: the place in the middle [m] and the height of the picture [m].
  Vec3 middle{};
  double height = 1;
  Stereo stereo = Stereo::none;
  double eye_separation = 0;          ///< [m]; 0: a thirtieth of the distance
  double opacity = 1;                 ///< a factor on that of the looks
  double opacity_shift = 0;           ///< of the values at which looks are opaque, of their range
  std::shared_ptr<const Field> field; ///< in place of its object's colours
  /// True while things move, if a body of many nodes is drawn with only some of them.
  bool is_rough = false;
  std::uint64_t number = 0; ///< another one: another look, field or view
};

/// A picture, and what is under its pixels.
struct Painted {
  std::uint64_t number = 0;
  int width = 0, height = 0;
  std::shared_ptr<const std::vector<std::uint8_t>> rgba;
  std::vector<std::int32_t> object; ///< per pixel; -1: background. Of stereo pictures the left eye's
  std::vector<float> depth;         ///< along the ray [m]; of 2D worlds empty
  Looking looking;
  std::shared_ptr<const WorldState> state;
  std::shared_ptr<const WorldScene> scene;
  double seconds = 0;   ///< that it took
  bool is_whole = true; ///< false: of fewer pixels, while things move

  struct Under {
    int object = -1;
    Vec3 world{}; ///< [m]
    Vec3 rest{};  ///< of the matter there, in the object's frame before it was deformed [m]
  };
  /// @param x, y in parts of the picture, 0 to 1 from the upper left
  /// @param reach  if nothing movable is there, the nearest movable pixel within this distance [pixels]
  /// counts, so that single voxels can be grabbed
  std::optional<Under> under(double x, double y, double reach = 0) const;
};

/// For 2D worlds: the place in the picture of a place in the world, in parts from the upper left, and the
/// inverse.
std::array<double, 2> flat_place(const Looking& looking, double aspect, const Vec3& world);
Vec3 flat_point(const Looking& looking, double aspect, double x, double y);
/// The view that shows a whole 2D world of any size. @param aspect width over height
Looking flat_looking(const WorldScene& scene, double aspect);

/// One thread's.
class Painter {
public:
  virtual ~Painter() = default;
  /// @param looks one an object, or fewer @return without number, scene and state
  virtual Painted paint(const WorldScene& scene, const WorldState& state, const Looking& looking) = 0;
};
/// Seen from above, cell by cell. 2D (and 1D) worlds.
std::unique_ptr<Painter> flat_painter();
/// Cast as volumes. 3D worlds. @param paints in place of looks' colours, one an object, or fewer; or null
std::unique_ptr<Painter> volume_painter(std::vector<std::optional<Seen>> looks, int threads,
                                        std::vector<std::shared_ptr<const render::Paint>> paints = {});

/// Makes pictures in a thread of its own, always of the newest state and view; while things move, of as few
/// pixels as keep to a thirtieth of a second, then whole.
class PainterLoop {
public:
  /// @param has_painted called from that thread
  PainterLoop(std::unique_ptr<Painter> painter, std::function<void()> has_painted);
  ~PainterLoop();

  void look(std::shared_ptr<const WorldScene> scene, std::shared_ptr<const WorldState> state,
            const Looking& looking);
  /// The newest; null before the first.
  std::shared_ptr<const Painted> newest() const;
  /// Whether what was last asked for is there, whole.
  bool is_idle() const;
  /// Every picture whole, whatever it takes.
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
  double seconds_whole_ = 0; ///< that a whole picture takes while things move, by the last ones
  std::uint64_t number_ = 0;
  bool has_coarse_ = false; ///< what coarse pictures are made of
  std::thread thread_;
};

/// `NAME.png`, without a folder.
bool is_name_of_picture(const std::string& name);
/// Writes a PNG of four bytes a pixel, whole or not at all, in the place of nothing or of a file that is no
/// input and no link. @param finish  called with the file before it has its name
/// @return why it could not; empty: it is there
std::string write_png(const std::string& file, int width, int height, const std::vector<std::uint8_t>& rgba,
                      const std::function<void(const std::filesystem::path&)>& finish = {});

} // namespace maille::live
