#pragma once
/// `maille live`: interactive manipulation of a world in a window.

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

/// A world and its appearance, read when the user chooses it.
struct Loaded {
  WorldScene scene;
  std::vector<std::optional<Seen>> looks; ///< one per object, or fewer
  std::vector<std::shared_ptr<const render::Paint>>
      paints;                     ///< likewise, or null: pictures, colours of labels
  std::vector<std::string> notes; ///< features of the scene that the interactive world lacks
};

/// One line of the menu.
struct Prototype {
  std::string name, title, what_to_do;
  std::filesystem::path scene;
};

/// The prototypes of 1995, and a calf from MRI. @param scenes folder of the scenes that are installed
std::vector<Prototype> standard_menu(const std::filesystem::path& scenes);

/// Functions that the caller provides to the window.
struct LiveTools {
  /// Reads a world. @throws InputError, std::exception with the error
  std::function<Loaded(const std::filesystem::path&)> load;
  /// Solves a body's scene by finite elements; empty if they are not available.
  std::function<Answer(const Scene&, const Control&)> finite_elements;
  /// Makes a film of numbered pictures `stem_0000.png`; @return the reason of a failure, or nothing
  std::function<std::optional<std::string>(const std::filesystem::path& stem, std::int64_t n, double seconds)>
      make_film;
  /// Marks a picture as one that later sessions may replace. @throws std::filesystem::filesystem_error
  std::function<void(const std::filesystem::path&)> add_mark;
};

/// An event of a script, at a time after the start [s].
struct ScriptedEvent {
  double at = 0;
  Event event;
};
/// Reads a table with one row per event: `time [s],event,x,y,button,name,value`; see docs/live.md.
/// @throws InputError with all errors
std::vector<ScriptedEvent> read_script(const std::filesystem::path& file);
std::vector<ScriptedEvent> parse_script(std::string_view text, const std::string& file);

struct LiveSettings {
  std::optional<std::filesystem::path> scene; ///< nothing: the menu
  std::vector<Prototype> menu;
  std::optional<std::filesystem::path> record;
  std::string method; ///< overrides the scene's method; empty: the scene's
  std::vector<ScriptedEvent> script;
  /// Each event of the script waits until the previous one is done and displayed, regardless of its time.
  bool in_step = false;
  std::shared_ptr<HandDevice> device;
  std::filesystem::path shots = "."; ///< folder of screenshots and films
  Stereo stereo = Stereo::none;
  double text_scale = 0; ///< 0: from the screen
  std::optional<double> frame_budget;
  int threads = 1;
  bool ends_with_script = true;
};

/// Results of a window's run.
struct LiveReport {
  std::int64_t pictures = 0, events = 0;
  double first_picture = 0;             ///< after the start [s]
  std::vector<double> event_to_picture; ///< latency of events that moved an object [s]
  std::vector<double> picture_seconds;  ///< intervals between pictures during motion [s]
  HandReport hand;
  std::string trajectory;                       ///< text of the last session's trajectory file
  std::shared_ptr<const WorldState> last_state; ///< final state of that trajectory
  std::int64_t penetrations = 0;                ///< at the end
  double text_scale = 1;                        ///< of the text
  bool has_lost = false;                        ///< a picture or recording could not be written
  std::vector<std::string> messages;            ///< displayed errors
};

/// Runs until the window is closed, or the script has ended.
LiveReport run_live(Window& window, const LiveSettings& settings, const LiveTools& tools);

/// Initial view of a world. @param width, height of the picture [pixels]
Looking first_looking(const WorldScene& scene, int width, int height);

} // namespace maille::live
