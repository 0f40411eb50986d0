#pragma once
/// What Dear ImGui draws, by the renderer of SDL; and our widgets in its terms.

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
  /// Fonts anew, of letters so high [pixels].
  void load_fonts(float size);

private:
  SDL_Renderer* renderer_;
  SDL_Texture* fonts_ = nullptr;
};

/// Draws the panel, and adds an event for each widget that was used.
void draw_panel(const Shown& shown, float left, float width, float height, std::vector<Event>& events);
void draw_overlay(const Shown& shown, float text_size);

} // namespace maille::live
