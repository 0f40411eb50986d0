/// The window on a screen.

#include "window/imgui_parts.hpp"
#include "window/screen_density.hpp"
#include "window/window_functions.hpp"

#include <backends/imgui_impl_sdl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace maille::live {

namespace {

[[noreturn]] void no_display(const std::string& why) {
  throw std::runtime_error(
      "cannot open a window: " + why +
      "\n  without a screen: xvfb-run -a maille live ..., or --headless with --script EVENTS.csv"
      "\n  over a network:   ssh -X, or set DISPLAY"
      "\n  no hand at all:   maille play SCENE TRAJECTORY");
}

class SdlWindow : public Window {
public:
  explicit SdlWindow(const WindowSettings& settings) {
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
    SDL_SetHint(SDL_HINT_RENDER_SCALE_QUALITY, "1");
    // Send pictures straight to the X server, not through a software-emulated GPU.
    SDL_SetHint(SDL_HINT_FRAMEBUFFER_ACCELERATION, "0");
    SDL_SetHint(SDL_HINT_VIDEO_X11_NET_WM_BYPASS_COMPOSITOR, "0");
    if (SDL_Init(SDL_INIT_VIDEO | (settings.game_controllers ? SDL_INIT_GAMECONTROLLER : 0u)) != 0)
      no_display(SDL_GetError());
    window_ =
        SDL_CreateWindow(settings.title.c_str(), SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED,
                         settings.width, settings.height, SDL_WINDOW_RESIZABLE | SDL_WINDOW_ALLOW_HIGHDPI);
    // Without a GPU the software renderer is much faster: a picture is one copy.
    if (window_ != nullptr)
      renderer_ = SDL_CreateRenderer(window_, -1, SDL_RENDERER_SOFTWARE);
    if (renderer_ == nullptr) {
      const std::string why = SDL_GetError();
      close();
      no_display(why);
    }
    wake_event_ = SDL_RegisterEvents(1);
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
    ImGui::StyleColorsLight();
    ImGui_ImplSDL2_InitForSDLRenderer(window_);
    parts_ = std::make_unique<ImguiRenderer>(renderer_);
    scale_ = settings.text_scale > 0 ? static_cast<float>(settings.text_scale) : density();
    set_text(scale_);
    if (settings.full_screen)
      set_full_screen(true);
    SDL_StartTextInput();
  }

  ~SdlWindow() override { close(); }

  std::vector<Event> poll(double seconds) override {
    std::vector<Event> events = std::move(used_);
    used_.clear();
    SDL_Event event;
    // Widgets react one frame after an event: two frames are drawn at once, so that a press shows.
    const int wait = !events.empty() || to_draw_ > 0 ? 0 : static_cast<int>(std::ceil(1000 * seconds));
    if (SDL_WaitEventTimeout(&event, wait) == 0)
      return events;
    do {
      take(event, events);
    } while (SDL_PollEvent(&event) != 0);
    for (Event& each : events)
      each.time = each.time == 0 ? seconds_now() : each.time;
    return events;
  }

  void show(const Shown& shown) override {
    to_draw_ = std::max(0, to_draw_ - 1);
    if (std::abs(shown.text_scale - scale_) > 1e-3f)
      set_text(shown.text_scale);
    if (width() < 1 || height() < 1)
      return;
    upload(shown);
    ImGui_ImplSDL2_NewFrame();
    ImGui::NewFrame();
    draw_overlay(shown, ImGui::GetFontSize());
    draw_panel(shown, static_cast<float>(width() - panel_width()), static_cast<float>(panel_width()),
               static_cast<float>(height()), used_);
    for (Event& event : used_)
      event.time = seconds_now();
    ImGui::Render();
    SDL_SetRenderDrawColor(renderer_, 255, 255, 255, 255);
    SDL_RenderClear(renderer_);
    const SDL_Rect place{0, 0, width() - panel_width(), height()};
    if (picture_ != nullptr && place.w > 0)
      SDL_RenderCopy(renderer_, picture_, nullptr, &place);
    parts_->draw(*ImGui::GetDrawData());
    if (wants_shot_)
      shot_ = read_pixels();
    wants_shot_ = false;
    SDL_RenderPresent(renderer_);
    last_ = shown;
  }

  void wake() override {
    SDL_Event event{};
    event.type = wake_event_;
    if (!SDL_HasEvent(wake_event_))
      SDL_PushEvent(&event);
  }

  int width() const override { return size()[0]; }
  int height() const override { return size()[1]; }
  int panel_width() const override {
    const int wanted = static_cast<int>(300 * scale_);
    return width() > 2 * wanted ? wanted : width() / 3;
  }
  double text_scale() const override { return static_cast<double>(scale_); }
  bool wants_drawing() const override { return to_draw_ > 0 || !used_.empty(); }
  std::string driver() const override {
    SDL_RendererInfo info{};
    SDL_GetRendererInfo(renderer_, &info);
    return std::string(SDL_GetCurrentVideoDriver()) + ", " + (info.name != nullptr ? info.name : "");
  }
  void set_full_screen(bool is_full) override {
    SDL_SetWindowFullscreen(window_, is_full ? SDL_WINDOW_FULLSCREEN_DESKTOP : 0);
    to_draw_ = 2;
  }
  std::vector<std::uint8_t> screenshot() override {
    wants_shot_ = true;
    show(last_);
    return std::move(shot_);
  }

private:
  std::array<int, 2> size() const {
    std::array<int, 2> size{0, 0};
    SDL_GetRendererOutputSize(renderer_, &size[0], &size[1]);
    return size;
  }

  /// Density: pixels per point on high-density screens; else the desktop's setting, else the screen's own
  /// density.
  float density() const {
    int points = 1;
    SDL_GetWindowSize(window_, &points, nullptr);
    const float ratio = static_cast<float>(size()[0]) / static_cast<float>(std::max(1, points));
    if (ratio > 1.05f)
      return ratio;
    float dots = static_cast<float>(dots_by_resources());
    if (dots == 0 && SDL_GetDisplayDPI(SDL_GetWindowDisplayIndex(window_), nullptr, &dots, nullptr) != 0)
      return 1;
    return text_scale_of(dots);
  }

  void set_text(float scale) {
    scale_ = scale;
    ImGuiStyle style;
    ImGui::StyleColorsLight(&style);
    style.ScaleAllSizes(scale);
    ImGui::GetStyle() = style;
    parts_->load_fonts(16 * scale);
    to_draw_ = 2;
  }

  void close() {
    if (parts_) {
      parts_.reset();
      ImGui_ImplSDL2_Shutdown();
      ImGui::DestroyContext();
    }
    for (auto& [id, pad] : pads_)
      SDL_GameControllerClose(pad);
    if (picture_ != nullptr)
      SDL_DestroyTexture(picture_);
    if (renderer_ != nullptr)
      SDL_DestroyRenderer(renderer_);
    if (window_ != nullptr)
      SDL_DestroyWindow(window_);
    SDL_Quit();
  }

  void upload(const Shown& shown) {
    if (!shown.rgba || shown.picture_number == uploaded_ || shown.width < 1 || shown.height < 1 ||
        shown.rgba->size() < std::size_t{4} * shown.width * shown.height)
      return;
    if (picture_ == nullptr || shown.width != picture_width_ || shown.height != picture_height_) {
      if (picture_ != nullptr)
        SDL_DestroyTexture(picture_);
      picture_ = SDL_CreateTexture(renderer_, SDL_PIXELFORMAT_ABGR8888, SDL_TEXTUREACCESS_STREAMING,
                                   shown.width, shown.height);
      picture_width_ = shown.width;
      picture_height_ = shown.height;
    }
    if (picture_ != nullptr)
      SDL_UpdateTexture(picture_, nullptr, shown.rgba->data(), 4 * shown.width);
    uploaded_ = shown.picture_number;
  }

  std::vector<std::uint8_t> read_pixels() const {
    std::vector<std::uint8_t> pixels(std::size_t{4} * width() * height());
    if (SDL_RenderReadPixels(renderer_, nullptr, SDL_PIXELFORMAT_ABGR8888, pixels.data(), 4 * width()) != 0)
      return {};
    for (std::size_t i = 3; i < pixels.size(); i += 4)
      pixels[i] = 255;
    return pixels;
  }

  /// Modifier keys at the time of an event: SDL's own state belongs to the last waiting event, when a quick
  /// Ctrl+Q is already released.
  void follow_modifiers(const SDL_Event& from) {
    if (from.type == SDL_KEYDOWN || from.type == SDL_KEYUP)
      modifiers_ = static_cast<SDL_Keymod>(from.key.keysym.mod);
    else if (from.type == SDL_WINDOWEVENT && from.window.event == SDL_WINDOWEVENT_FOCUS_GAINED)
      modifiers_ = SDL_GetModState();
  }
  void add_modifiers(Event& event) const {
    event.shift = (modifiers_ & KMOD_SHIFT) != 0;
    event.control = (modifiers_ & KMOD_CTRL) != 0;
    event.alt = (modifiers_ & KMOD_ALT) != 0;
  }

  /// Converts window points to pixels.
  double pixels(int points) const {
    int width = 1;
    SDL_GetWindowSize(window_, &width, nullptr);
    return static_cast<double>(points) * size()[0] / std::max(1, width);
  }

  void take(const SDL_Event& from, std::vector<Event>& events) {
    if (from.type == wake_event_)
      return;
    ImGui_ImplSDL2_ProcessEvent(&from);
    follow_modifiers(from);
    Event event;
    add_modifiers(event);
    const bool is_over_panel = ImGui::GetIO().WantCaptureMouse;
    const bool is_drag = from.type == SDL_MOUSEMOTION && from.motion.state != 0 && !is_over_panel;
    if (!is_drag) // widgets do not change during a drag, and the drag causes a picture
      to_draw_ = 2;
    switch (from.type) {
    case SDL_QUIT:
      event.kind = EventKind::close;
      break;
    case SDL_WINDOWEVENT:
      if (from.window.event != SDL_WINDOWEVENT_SIZE_CHANGED &&
          from.window.event != SDL_WINDOWEVENT_MINIMIZED && from.window.event != SDL_WINDOWEVENT_RESTORED)
        return;
      event.kind = EventKind::resize;
      event.x = from.window.event == SDL_WINDOWEVENT_MINIMIZED ? 0 : width();
      event.y = from.window.event == SDL_WINDOWEVENT_MINIMIZED ? 0 : height();
      break;
    case SDL_MOUSEMOTION:
      event.kind = EventKind::pointer_move;
      event.x = pixels(from.motion.x);
      event.y = pixels(from.motion.y);
      break;
    case SDL_MOUSEBUTTONDOWN:
    case SDL_MOUSEBUTTONUP:
      event.kind = from.type == SDL_MOUSEBUTTONDOWN ? EventKind::pointer_down : EventKind::pointer_up;
      event.x = pixels(from.button.x);
      event.y = pixels(from.button.y);
      event.button = from.button.button == SDL_BUTTON_LEFT    ? 1
                     : from.button.button == SDL_BUTTON_RIGHT ? 3
                                                              : 2;
      if (event.kind == EventKind::pointer_down && (is_over_panel || event.x >= width() - panel_width()))
        return;
      break;
    case SDL_MOUSEWHEEL:
      if (is_over_panel)
        return;
      event.kind = EventKind::wheel;
      event.value = static_cast<double>(from.wheel.preciseY);
      break;
    case SDL_KEYDOWN:
    case SDL_KEYUP:
      if (ImGui::GetIO().WantTextInput)
        return;
      event.kind = from.type == SDL_KEYDOWN ? EventKind::key_down : EventKind::key_up;
      event.name = SDL_GetKeyName(from.key.keysym.sym);
      break;
    case SDL_CONTROLLERDEVICEADDED:
      if (SDL_GameController* const pad = SDL_GameControllerOpen(from.cdevice.which))
        pads_[SDL_JoystickInstanceID(SDL_GameControllerGetJoystick(pad))] = pad;
      return;
    case SDL_CONTROLLERDEVICEREMOVED:
      if (const auto pad = pads_.find(from.cdevice.which); pad != pads_.end()) {
        SDL_GameControllerClose(pad->second);
        pads_.erase(pad);
      }
      event.kind = EventKind::stick_lost;
      break;
    case SDL_CONTROLLERAXISMOTION:
      event.kind = EventKind::stick;
      event.name = SDL_GameControllerGetStringForAxis(static_cast<SDL_GameControllerAxis>(from.caxis.axis));
      event.value = from.caxis.value / 32768.0;
      break;
    case SDL_CONTROLLERBUTTONDOWN:
    case SDL_CONTROLLERBUTTONUP:
      event.kind = EventKind::stick;
      event.name =
          SDL_GameControllerGetStringForButton(static_cast<SDL_GameControllerButton>(from.cbutton.button));
      event.value = from.type == SDL_CONTROLLERBUTTONDOWN ? 1 : 0;
      break;
    default:
      return;
    }
    events.push_back(event);
  }

  SDL_Window* window_ = nullptr;
  SDL_Renderer* renderer_ = nullptr;
  SDL_Texture* picture_ = nullptr;
  int picture_width_ = 0, picture_height_ = 0;
  std::uint64_t uploaded_ = 0;
  std::unique_ptr<ImguiRenderer> parts_;
  float scale_ = 1;
  std::uint32_t wake_event_ = 0;
  std::map<SDL_JoystickID, SDL_GameController*> pads_;
  std::vector<Event> used_;
  Shown last_;
  int to_draw_ = 2;
  SDL_Keymod modifiers_ = KMOD_NONE; ///< of the processed events
  bool wants_shot_ = false;
  std::vector<std::uint8_t> shot_;
};

} // namespace

} // namespace maille::live

extern "C" const void* maille_plugin(std::size_t layout, const void* host);

extern "C" const void* maille_plugin(std::size_t layout, const void* /*host*/) {
  using namespace maille::live;
  static constexpr WindowFunctions functions{[](const WindowSettings& settings) -> std::unique_ptr<Window> {
    return std::make_unique<SdlWindow>(settings);
  }};
  return layout == window_layout ? &functions : nullptr;
}
