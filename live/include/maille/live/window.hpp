#pragma once
/// Window interface: events in; picture, overlay lines and a panel of widgets out. Implemented by SDL and
/// Dear ImGui, or without a window.

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille::live {

enum class EventKind {
  pointer_move,
  pointer_down,
  pointer_up,
  wheel,    ///< `value`: notches, > 0 away from the user
  key_down, ///< `name`: key name of SDL: `A`, `Space`, `Left`, `F11`
  key_up,
  widget,     ///< `name` of a widget, and its new `value` or `text`
  resize,     ///< to `x`, `y` pixels; 0 if the window is hidden
  stick,      ///< game controller: `name` of the axis, `value` from -1 to 1
  stick_lost, ///< the controller was disconnected
  shot,       ///< from scripts: saves a picture to the file `text`
  close,
};

/// Time by std::chrono::steady_clock [s].
inline double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

struct Event {
  EventKind kind = EventKind::pointer_move;
  double x = 0, y = 0; ///< [pixels] of the window, from the upper left
  int button = 0;      ///< 1 left, 2 middle, 3 right
  bool shift = false, control = false, alt = false;
  double value = 0;
  std::string name, text;
  double time = 0; ///< of arrival, by seconds_now() [s]
};

/// One line of the panel.
struct Widget {
  enum class Kind { text, heading, button, slider, choice, check };
  Kind kind = Kind::text;
  std::string name;  ///< unique; `name` of its events
  std::string label; ///< displayed text
  double value = 0;  ///< slider: value; check: 0 or 1; choice: index
  double low = 0, high = 1;
  bool logarithmic = false;
  std::vector<std::string> choices;
  bool emphasis = false; ///< an error or an important text
};

/// A polyline over the picture, in window pixels.
struct OverlayLine {
  std::vector<std::array<float, 2>> points;
  std::array<float, 4> colour{1, 1, 1, 1};
  float width = 2;
};
struct OverlayText {
  double x = 0, y = 0;
  std::string text;
  std::array<float, 4> colour{1, 1, 1, 1};
  bool large = false;
};

/// Contents of the window. The picture is stretched to the window without the panel.
struct Shown {
  int width = 0, height = 0;                             ///< of the picture [pixels]
  std::shared_ptr<const std::vector<std::uint8_t>> rgba; ///< width * height * 4 bytes, rows from the top
  std::uint64_t picture_number = 0;                      ///< changes with the picture
  std::vector<Widget> panel;
  std::vector<OverlayLine> lines;
  std::vector<OverlayText> texts;
  float text_scale = 1;
};

/// For use by one thread only, except wake().
class Window {
public:
  virtual ~Window() = default;
  /// Waits up to `seconds` for events. @return events in order; widget events belong to the last show()
  virtual std::vector<Event> poll(double seconds) = 0;
  virtual void show(const Shown& shown) = 0;
  /// Ends a poll, from any thread.
  virtual void wake() = 0;
  virtual int width() const = 0;
  virtual int height() const = 0;
  /// Width of the panel at the right edge [pixels].
  virtual int panel_width() const = 0;
  /// Scale of the text, from the screen's density.
  virtual double text_scale() const { return 1; }
  /// True if the last contents must be drawn again: pressed buttons appear with a delay.
  virtual bool wants_drawing() const { return false; }
  /// Name of the video driver and renderer.
  virtual std::string driver() const = 0;
  virtual void set_full_screen(bool is_full) = 0;
  /// The window contents as displayed, four bytes per pixel. Empty if not available.
  virtual std::vector<std::uint8_t> screenshot() = 0;
};

/// A window without a screen: takes queued events and stores the shown pictures.
class HeadlessWindow : public Window {
public:
  HeadlessWindow(int width, int height) : width_(width), height_(height) {}

  void put(Event event);
  const Shown& shown() const { return shown_; }
  /// A widget of the last panel, by name; null if it does not exist.
  const Widget* widget(std::string_view name) const;

  std::vector<Event> poll(double seconds) override;
  void show(const Shown& shown) override;
  void wake() override;
  int width() const override { return width_; }
  int height() const override { return height_; }
  int panel_width() const override { return 0; }
  std::string driver() const override { return "no window"; }
  void set_full_screen(bool) override {}
  std::vector<std::uint8_t> screenshot() override;

private:
  int width_, height_;
  Shown shown_;
  std::deque<Event> events_;
  std::mutex lock_;
  std::condition_variable bell_;
  bool is_awake_ = false;
};

struct WindowSettings {
  std::string title = "Maille";
  int width = 1280, height = 800;
  double text_scale = 0; ///< 0: from the screen's density
  bool full_screen = false;
  bool game_controllers = false;
};

/// Whether this build has windows.
bool has_windows();
/// A window on the screen.
/// @throws std::runtime_error with instructions, without a display or in builds without windows
std::unique_ptr<Window> open_window(const WindowSettings& settings);

} // namespace maille::live
