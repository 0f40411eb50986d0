#pragma once
/// A window as this room sees it: events in, a picture, lines over it and a panel of widgets out. SDL and
/// Dear ImGui stand behind it, or nothing at all.

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille::live {

enum class EventKind {
  pointer_move,
  pointer_down,
  pointer_up,
  wheel,    ///< `value`: notches, away from the user > 0
  key_down, ///< `name`: as SDL names keys: `A`, `Space`, `Left`, `F11`
  key_up,
  widget,     ///< `name` of a widget whose value has become `value` or `text`
  resize,     ///< to `x`, `y` pixels, 0 where nothing of it is to be seen
  stick,      ///< of a game controller: `name` of the axis, `value` from -1 to 1
  stick_lost, ///< the controller was pulled out
  shot,       ///< of scripts: a picture into the file `text`
  close,
};

struct Event {
  EventKind kind = EventKind::pointer_move;
  double x = 0, y = 0; ///< [pixels] of the window, from the upper left
  int button = 0;      ///< 1 left, 2 middle, 3 right
  bool shift = false, control = false, alt = false;
  double value = 0;
  std::string name, text;
  /// When it came, by std::chrono::steady_clock [s].
  double time = 0;
};

/// One line of the panel.
struct Widget {
  enum class Kind { text, heading, button, slider, choice, check };
  Kind kind = Kind::text;
  std::string name;  ///< of its events, of its own
  std::string label; ///< what is read
  double value = 0;  ///< of a slider; of a check 0 or 1; of a choice its number
  double low = 0, high = 1;
  bool logarithmic = false;
  std::vector<std::string> choices;
  bool emphasis = false; ///< a fault, or what needs to be read
};

/// A line of points over the picture, in window pixels.
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

/// What is to be seen. The picture is stretched to the window without the panel.
struct Shown {
  int width = 0, height = 0;                             ///< of the picture [pixels]
  std::shared_ptr<const std::vector<std::uint8_t>> rgba; ///< width * height * 4 bytes, rows from the top
  std::uint64_t picture_number = 0;                      ///< another one: another picture
  std::vector<Widget> panel;
  std::vector<OverlayLine> lines;
  std::vector<OverlayText> texts;
  float text_scale = 1;
};

/// One thread's, but for wake().
class Window {
public:
  virtual ~Window() = default;
  /// Waits up to that long for events. @return those that came, in order; of widgets, those of the last show
  virtual std::vector<Event> poll(double seconds) = 0;
  virtual void show(const Shown& shown) = 0;
  /// Ends a poll, from any thread.
  virtual void wake() = 0;
  virtual int width() const = 0;
  virtual int height() const = 0;
  /// Pixels of the panel at the right edge.
  virtual int panel_width() const = 0;
  /// Scale of the letters, from the screen's density.
  virtual double text_scale() const { return 1; }
  /// Whether what was shown last is to be drawn again: presses of buttons show a moment later.
  virtual bool wants_drawing() const { return false; }
  /// What pictures are shown by, in words.
  virtual std::string driver() const = 0;
  virtual void set_full_screen(bool is_full) = 0;
  /// Everything that is shown, as it is seen: four bytes a pixel. Empty where it cannot be had.
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
  struct Waiting;
  int width_, height_;
  Shown shown_;
  std::deque<Event> events_;
  std::shared_ptr<Waiting> waiting_ = make_waiting();
  static std::shared_ptr<Waiting> make_waiting();
};

struct WindowSettings {
  std::string title = "Maille";
  int width = 1280, height = 800;
  double text_scale = 0; ///< 0: of the screen's density
  bool full_screen = false;
  bool game_controllers = false;
};

/// Whether this build has windows.
bool has_windows();
/// A window on the screen.
/// @throws std::runtime_error saying what to do where there is no display, or no windows in this build
std::unique_ptr<Window> open_window(const WindowSettings& settings);

} // namespace maille::live
