#pragma once
/// The application: contents of the window and handling of its events.

#include "maille/live/live.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <map>

namespace maille::live {

/// Compares the present state with elasticity and with finite elements, in its own thread.
class Judge {
public:
  struct Verdict {
    int object = -1;
    std::shared_ptr<const Displacement> of; ///< the compared displacement
    std::optional<double> relative;         ///< relative error of the displacement (RMS)
    std::string why_not;
    double seconds = 0;
    std::shared_ptr<const Displacement> difference; ///< answer minus truth
    bool is_fem = false;
  };
  Judge(const Session& session, const LiveTools& tools, int threads, std::function<void()> has_judged);
  ~Judge();
  /// Requests a comparison: the newest request replaces a waiting one; a running one continues.
  void estimate(int object);
  void finite_elements(int object);
  /// True if the verdict belongs to the object's present state.
  static bool is_of(const std::shared_ptr<const Verdict>& verdict, const WorldState& state) {
    return verdict && verdict->object >= 0 &&
           static_cast<std::size_t>(verdict->object) < state.displacements.size() && verdict->of &&
           verdict->of == state.displacements[verdict->object];
  }
  std::shared_ptr<const Verdict> estimated() const { return estimated_.load(); }
  std::shared_ptr<const Verdict> of_fem() const { return fem_.load(); }
  bool is_at_fem() const { return is_at_fem_; }

private:
  struct Task {
    int object = -1;
    bool is_fem = false;
  };
  void run();
  void ask(const Task& task);
  Verdict judge(const Task& task, const WorldState& state, const Scene& question) const;

  const Session& session_;
  const LiveTools& tools_;
  int threads_;
  std::function<void()> has_judged_;
  std::mutex lock_;
  std::optional<Task> next_estimate_, next_fem_;
  std::condition_variable bell_;
  std::atomic<std::shared_ptr<const Verdict>> estimated_, fem_;
  std::atomic<bool> is_at_fem_{false}, is_stopping_{false};
  std::thread thread_;
};

/// A world in a picture of width x height pixels: the lines over it, in window pixels. A rigid object has
/// rings that rotate it: one per world axis; in 2D only the axis out of the plane.
struct Sight {
  const WorldScene& scene;
  const WorldState& state;
  const Looking& looking;
  int width, height;

  /// Window position of a world position; z: depth in front of the eye.
  Vec3 in_window(const Eigen::Vector3d& place) const;
  bool has_rings(int object) const;
  std::vector<std::array<float, 2>> ring(int object, int axis) const;
  /// All rings; empty if the object has none.
  std::vector<OverlayLine> rings(int object, int grabbed) const;
  /// World axis through a point, which constrains the drag.
  OverlayLine axis_line(int axis, const Eigen::Vector3d& through, double half_length) const;
  /// Circles that mark rigid objects too small to find otherwise.
  std::vector<OverlayLine> marks(double text_scale) const;
  /// Axis of the ring under a window position; -1: none.
  int ring_at(int object, double x, double y) const;
  /// Rotation of a ring between two pointer positions [rad].
  double turned(int object, int axis, const std::array<double, 2>& from,
                const std::array<double, 2>& to) const;
};

/// Centre and half size of an object [m].
std::pair<Eigen::Vector3d, double> ball_about(const WorldScene& scene, const WorldState& state, int object);

class App {
public:
  App(Window& window, const LiveSettings& settings, const LiveTools& tools);
  ~App();
  LiveReport run();

private:
  // app.cpp, show.cpp
  struct Eye {
    Looking looking;
    int width;                                  ///< width of its picture [pixels]
    double left;                                ///< left edge of its picture [pixels]
    std::optional<std::array<float, 4>> colour; ///< colour of lines for this eye only
  };
  std::vector<Eye> eyes() const;
  Sight sight() const {
    return {*scene_, *state_, looking_, std::max(1, looking_.view.width), std::max(1, looking_.view.height)};
  }
  void load(const std::filesystem::path& file);
  void unload();
  void take_events(std::vector<Event> events);
  void take(const Event& event);
  void resize();
  void show();
  void ask_for_picture();
  void follow_state();
  void take_picture();
  void save_shot(std::string file);
  bool is_idle() const;
  bool is_seen_in_pictures(const std::vector<Event>& events) const;
  std::vector<Event> scripted(double now);
  void write_film_picture();
  void end_film();
  void say(const std::string& message);
  // touch.cpp
  void pointer_down(const Event& event);
  void pointer_move(const Event& event);
  void pointer_up(const Event& event);
  void wheel(const Event& event);
  void key(const Event& event);
  void move_key(const Event& event);
  void turn_held(const Eigen::Vector3d& axis, double angle, double time);
  void drag_to(double x, double y, double time);
  void keep_to_axis(int axis, double time);
  Eigen::Vector3d on_axis(double x, double y, int axis) const;
  Eigen::Vector3d on_view_plane(double x, double y, const Eigen::Vector3d& through) const;
  std::vector<std::int64_t> patch_at(int object, const Vec3& rest) const;
  double reach_of(const Painted& painted) const;
  void add_tool(double radius_in_cells);
  void follow_device();
  // panel.cpp
  void take_widget(const Event& event);
  std::vector<Widget> panel() const;
  std::vector<Widget> menu_panel() const;
  std::string what_to_do_with(const std::filesystem::path& file) const;
  std::vector<OverlayText> corner() const;
  void colour_by(ColourBy what);
  void refresh_field();
  int soft_object() const;
  bool is_newly_judged();
  bool is_felt() const;

  Window& window_;
  const LiveSettings& settings_;
  const LiveTools& tools_;
  std::unique_ptr<Session> session_;
  std::unique_ptr<PainterLoop> painter_;
  std::shared_ptr<const Painted> in_window_;
  std::unique_ptr<Judge> judge_;
  std::shared_ptr<HandDevice> device_;
  GamePad* game_pad_ = nullptr;
  std::optional<std::filesystem::path> file_;
  std::string what_to_do_;
  std::vector<std::string> notes_, faults_;

  Looking looking_;
  std::uint64_t shown_state_ = 0, shown_picture_ = 0;
  std::shared_ptr<const Displacement> judged_; ///< displacement of the last requested estimate
  std::shared_ptr<const WorldState> state_;
  std::shared_ptr<const WorldScene> scene_;
  std::uint64_t scene_number_ = 0;

  // The pointer.
  enum class Drag { none, object, orbit, pan, ring };
  Drag drag_ = Drag::none;
  double last_x_ = 0, last_y_ = 0;
  Eigen::Vector3d grabbed_at_ = Eigen::Vector3d::Zero(); ///< world position at the start of the drag
  deform::Pose grabbed_pose_;
  double depth_ = 0; ///< motion along the line of sight since then [m]
  int ring_axis_ = -1;
  int axis_ = -1;                     ///< world axis that constrains the drag; -1: none, or no drag
  bool has_rings_ = true;             ///< show rings around the selected object
  std::deque<double> waiting_events_; ///< times of hand motions not displayed yet [s]
  int selected_ = -1;
  bool keeps_pinned_ = false;
  std::uint32_t buttons_ = 0;

  // The panel.
  ColourBy colour_by_ = ColourBy::look;
  double patch_radius_ = 0; ///< [m]
  double stretch_ = 1.25, compress_ = 0.75, shear_ = 0.25, stiffness_ = 1;
  int limits_choice_ = 0; ///< the scene's, the material's, none, given
  bool pins_ = false;
  std::optional<double> budget_;
  /// Changed constants that wait until the physics is idle.
  std::map<std::string, WorldSetting> pending_;
  double text_scale_ = 1;
  bool is_full_screen_ = false, wants_stop_ = false, has_keys_ = false;
  std::optional<std::filesystem::path> film_;
  std::int64_t film_pictures_ = 0;
  double film_next_ = 0;
  int shots_ = 0;

  double began_ = 0;
  std::size_t next_scripted_ = 0;
  double script_began_ = 0;
  std::optional<deform::Pose> shown_proxy_;
  double last_picture_at_ = 0, last_event_shown_ = 0, still_since_ = 0, last_shown_ = 0;
  bool has_new_numbers_ = false; ///< new numbers in the corner for a state of unchanged appearance
  bool was_open_ = false;
  std::size_t n_objects_ = 0;
  std::shared_ptr<const Judge::Verdict> coloured_, shown_estimate_, shown_fem_;
  LiveReport report_;
};

} // namespace maille::live
