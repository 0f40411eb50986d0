#pragma once
/// Drawing of Dear ImGui by SDL's renderer, and our widgets in Dear ImGui.

#include "maille/live/window.hpp"

#include <SDL.h>
#include <imgui.h>

namespace maille::live {

/// Debian's Dear ImGui is built without its renderer for SDL.
class ImguiRenderer {
public:
  explicit ImguiRenderer(SDL_Renderer* renderer);
  ~ImguiRenderer();
  ImguiRenderer(const ImguiRenderer&) = delete;
  ImguiRenderer& operator=(const ImguiRenderer&) = delete;
  void draw(const ImDrawData& data);
  /// Loads the fonts again at this height [pixels].
  void load_fonts(float size);

private:
  SDL_Renderer* renderer_;
  SDL_Texture* fonts_ = nullptr;
};

/// Draws the panel, and adds an event for each used widget.
void draw_panel(const Shown& shown, float left, float width, float height, std::vector<Event>& events);
void draw_overlay(const Shown& shown, float text_size);

} // namespace maille::live
