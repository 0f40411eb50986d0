#include "window/imgui_parts.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace maille::live {

namespace {

ImU32 colour_of(const std::array<float, 4>& c) {
  return ImGui::ColorConvertFloat4ToU32({c[0], c[1], c[2], c[3]});
}

Event used(const Widget& widget, double value, std::string text = {}) {
  Event event;
  event.kind = EventKind::widget;
  event.name = widget.name;
  event.value = value;
  event.text = std::move(text);
  return event;
}

void draw_choice(const Widget& widget, std::vector<Event>& events) {
  const auto now = static_cast<std::size_t>(std::max(0.0, widget.value));
  const char* preview = now < widget.choices.size() ? widget.choices[now].c_str() : "";
  if (!ImGui::BeginCombo(("##" + widget.name).c_str(), preview))
    return;
  for (std::size_t i = 0; i < widget.choices.size(); ++i)
    if (ImGui::Selectable(widget.choices[i].c_str(), i == now))
      events.push_back(used(widget, static_cast<double>(i), widget.choices[i]));
  ImGui::EndCombo();
}

void draw_widget(const Widget& widget, std::vector<Event>& events) {
  switch (widget.kind) {
  case Widget::Kind::heading:
    ImGui::Spacing();
    ImGui::Separator();
    ImGui::TextUnformatted(widget.label.c_str());
    break;
  case Widget::Kind::text:
    if (widget.emphasis)
      ImGui::PushStyleColor(ImGuiCol_Text, ImVec4(0.75f, 0.12f, 0.06f, 1));
    ImGui::PushTextWrapPos(0);
    ImGui::TextUnformatted(widget.label.c_str());
    ImGui::PopTextWrapPos();
    if (widget.emphasis)
      ImGui::PopStyleColor();
    break;
  case Widget::Kind::button:
    if (ImGui::Button((widget.label + "##" + widget.name).c_str(), ImVec2(-1, 0)))
      events.push_back(used(widget, 1));
    break;
  case Widget::Kind::slider: {
    auto value = static_cast<float>(widget.value);
    ImGui::TextUnformatted(widget.label.c_str());
    const bool is_whole = widget.high - widget.low > 5 && !widget.logarithmic;
    if (ImGui::SliderFloat(("##" + widget.name).c_str(), &value, static_cast<float>(widget.low),
                           static_cast<float>(widget.high), is_whole ? "%.0f" : "%.3g",
                           widget.logarithmic ? ImGuiSliderFlags_Logarithmic : ImGuiSliderFlags_None))
      events.push_back(used(widget, static_cast<double>(value)));
    break;
  }
  case Widget::Kind::choice:
    ImGui::TextUnformatted(widget.label.c_str());
    draw_choice(widget, events);
    break;
  case Widget::Kind::check: {
    bool is_on = widget.value != 0;
    if (ImGui::Checkbox((widget.label + "##" + widget.name).c_str(), &is_on))
      events.push_back(used(widget, is_on ? 1 : 0));
    break;
  }
  }
}

} // namespace

ImguiRenderer::ImguiRenderer(SDL_Renderer* renderer) : renderer_(renderer) {}

ImguiRenderer::~ImguiRenderer() {
  if (fonts_ != nullptr)
    SDL_DestroyTexture(fonts_);
}

void ImguiRenderer::load_fonts(float size) {
  ImGuiIO& io = ImGui::GetIO();
  io.Fonts->Clear();
  ImFont* font = nullptr;
  for (const char* file : {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
                           "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf"})
    if (font == nullptr && std::filesystem::exists(file))
      font = io.Fonts->AddFontFromFileTTF(file, size);
  if (font == nullptr) { // the built-in one is 13 pixels high, sharp at integer multiples
    ImFontConfig config;
    config.SizePixels = 13 * std::max(1.0f, std::round(size / 13));
    io.Fonts->AddFontDefault(&config);
  }
  unsigned char* pixels = nullptr;
  int width = 0, height = 0;
  io.Fonts->GetTexDataAsRGBA32(&pixels, &width, &height);
  if (fonts_ != nullptr)
    SDL_DestroyTexture(fonts_);
  fonts_ = SDL_CreateTexture(renderer_, SDL_PIXELFORMAT_ABGR8888, SDL_TEXTUREACCESS_STATIC, width, height);
  if (fonts_ == nullptr)
    return;
  SDL_UpdateTexture(fonts_, nullptr, pixels, 4 * width);
  SDL_SetTextureBlendMode(fonts_, SDL_BLENDMODE_BLEND);
  SDL_SetTextureScaleMode(fonts_, SDL_ScaleModeLinear);
  io.Fonts->SetTexID(fonts_);
}

void ImguiRenderer::draw(const ImDrawData& data) {
  for (int n = 0; n < data.CmdListsCount; ++n) {
    const ImDrawList& list = *data.CmdLists[n];
    for (const ImDrawCmd& command : list.CmdBuffer) {
      if (command.UserCallback != nullptr)
        continue;
      const ImVec4& box = command.ClipRect;
      const SDL_Rect clip{static_cast<int>(box.x), static_cast<int>(box.y), static_cast<int>(box.z - box.x),
                          static_cast<int>(box.w - box.y)};
      if (clip.w <= 0 || clip.h <= 0)
        continue;
      SDL_RenderSetClipRect(renderer_, &clip);
      const ImDrawVert* const vertices = list.VtxBuffer.Data + command.VtxOffset;
      const auto* const bytes = reinterpret_cast<const unsigned char*>(vertices);
      SDL_RenderGeometryRaw(
          renderer_, static_cast<SDL_Texture*>(command.GetTexID()),
          reinterpret_cast<const float*>(bytes + offsetof(ImDrawVert, pos)), sizeof(ImDrawVert),
          reinterpret_cast<const SDL_Color*>(bytes + offsetof(ImDrawVert, col)), sizeof(ImDrawVert),
          reinterpret_cast<const float*>(bytes + offsetof(ImDrawVert, uv)), sizeof(ImDrawVert),
          list.VtxBuffer.Size - static_cast<int>(command.VtxOffset), list.IdxBuffer.Data + command.IdxOffset,
          static_cast<int>(command.ElemCount), sizeof(ImDrawIdx));
    }
  }
  SDL_RenderSetClipRect(renderer_, nullptr);
}

void draw_panel(const Shown& shown, float left, float width, float height, std::vector<Event>& events) {
  if (width < 8 || height < 8)
    return;
  ImGui::SetNextWindowPos({left, 0});
  ImGui::SetNextWindowSize({width, height});
  ImGui::Begin("panel", nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoSavedSettings);
  ImGui::PushItemWidth(-1);
  for (const Widget& widget : shown.panel)
    draw_widget(widget, events);
  ImGui::PopItemWidth();
  ImGui::End();
}

void draw_overlay(const Shown& shown, float text_size) {
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  for (const OverlayLine& line : shown.lines) {
    std::vector<ImVec2> points;
    for (const auto& point : line.points)
      points.push_back({point[0], point[1]});
    list.AddPolyline(points.data(), static_cast<int>(points.size()), colour_of(line.colour), 0, line.width);
  }
  for (const OverlayText& text : shown.texts) {
    const float size = text.large ? 1.4f * text_size : text_size;
    const ImVec2 at{static_cast<float>(text.x), static_cast<float>(text.y)};
    const ImVec2 extent = ImGui::GetFont()->CalcTextSizeA(size, 1e6f, 0, text.text.c_str(),
                                                          text.text.c_str() + text.text.size());
    list.AddRectFilled({at.x - 4, at.y - 2}, {at.x + extent.x + 4, at.y + extent.y + 2},
                       IM_COL32(255, 255, 255, 205), 3);
    list.AddText(ImGui::GetFont(), size, at, colour_of(text.colour), text.text.c_str());
  }
}

} // namespace maille::live
