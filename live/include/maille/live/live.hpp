#pragma once
/// `maille live`: a world in the hand, in a window.

#include "maille/live/device.hpp"
#include "maille/live/picture.hpp"
#include "maille/live/session.hpp"
#include "maille/live/window.hpp"

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace maille::live {

/// What can be taken up: read when it is chosen.
struct Loaded {
  WorldScene scene;
  std::vector<std::optional<Seen>> looks; ///< one an object, or fewer
  std::vector<std::shared_ptr<const render::Paint>>
      paints;                     ///< likewise, or null: pictures, colours of labels
  std::vector<std::string> notes; ///< what the scene asks for and the hand's world has not
};

/// One line of the menu.
struct Prototype {
  std::string name, title, what_to_do;
  std::filesystem::path scene;
};

/// The prototypes of 1995, and a calf from MRI. @param scenes folder of the scenes that come along
std::vector<Prototype> standard_menu(const std::filesystem::path& scenes);

/// What the window cannot do by itself.
struct LiveTools {
  /// @throws InputError, std::exception with what is wrong
  std::function<Loaded(const std::filesystem::path&)> load;
  /// Finite elements' answer to a body's question; empty where there are none.
  std::function<Answer(const Scene&, const Control&)> finite_elements;
  /// Makes a film of numbered pictures `stem_0000.png`; @return why not, or nothing
  std::function<std::optional<std::string>(const std::filesystem::path& stem, std::int64_t n, double seconds)>
      make_film;
  /// Marks a picture as one that later sessions may replace. @throws std::filesystem::filesystem_error
  std::function<void(const std::filesystem::path&)> add_mark;
};

/// An event of a script, at a time after its begin [s].
struct ScriptedEvent {
  double at = 0;
  Event event;
};
/// A table with a row an event: `time [s],event,x,y,button,name,value`. docs/live.md says what stands in it.
/// @throws InputError with every fault
std::vector<ScriptedEvent> read_script(const std::filesystem::path& file);
std::vector<ScriptedEvent> parse_script(std::string_view text, const std::string& file);

struct LiveSettings {
  std::optional<std::filesystem::path> scene; ///< nothing: the menu
  std::vector<Prototype> menu;
  std::optional<std::filesystem::path> record;
  std::string method; ///< in place of the scene's; empty: that
  std::vector<ScriptedEvent> script;
  /// Each event of the script waits until all of the one before has been done and shown, whatever its time.
  bool in_step = false;
  std::shared_ptr<HandDevice> device;
  std::filesystem::path shots = "."; ///< folder of screenshots and films
  Stereo stereo = Stereo::none;
  double text_scale = 0; ///< 0: of the screen
  std::optional<double> frame_budget;
  int threads = 1;
  bool ends_with_script = true;
};

/// What a window's run came to.
struct LiveReport {
  std::int64_t pictures = 0, events = 0;
  double first_picture = 0;             ///< after the begin [s]
  std::vector<double> event_to_picture; ///< [s], of events that moved something
  std::vector<double> picture_seconds;  ///< from one picture to the next while things moved [s]
  HandReport hand;
  std::string trajectory;                       ///< of the last session, as its file has it
  std::shared_ptr<const WorldState> last_state; ///< that its trajectory leads to
  std::int64_t penetrations = 0;                ///< at the end
  double text_scale = 1;                        ///< of letters
  bool has_lost = false;                        ///< a picture or recording that could not be written
  std::vector<std::string> messages;            ///< faults that were shown
};

/// Runs until the window is closed, or the script has ended.
LiveReport run_live(Window& window, const LiveSettings& settings, const LiveTools& tools);

/// How a world is first looked at. @param width, height of the picture [pixels]
Looking first_looking(const WorldScene& scene, int width, int height);

} // namespace maille::live
