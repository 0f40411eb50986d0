// Debian's VTK supports only X windows. Without an X server we create an OpenGL context with EGL and pass it
// to vtkGenericOpenGLRenderWindow, which draws into the current context.
#include "drawing.hpp"

#include "maille/base/arena.hpp"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <dlfcn.h>
#include <fmt/format.h>

#include <vtkCallbackCommand.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkNew.h>

#include <array>
#include <cstdlib>
#include <vector>

namespace maille::studies {
namespace {

template<typename Function>
Function egl_function(const char* name) {
  return reinterpret_cast<Function>(eglGetProcAddress(name));
}

/// Displays for drawing without a window, the most portable first: Mesa's (software if necessary), then each
/// graphics card.
std::vector<EGLDisplay> egl_displays() {
  std::vector<EGLDisplay> displays;
  const auto get_display = egl_function<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
  if (get_display == nullptr)
    return displays;
  displays.push_back(get_display(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr));
  const auto query_devices = egl_function<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
  std::array<EGLDeviceEXT, 16> devices{};
  EGLint n_devices = 0;
  if (query_devices != nullptr &&
      query_devices(static_cast<EGLint>(devices.size()), devices.data(), &n_devices))
    for (EGLint i = 0; i < n_devices; ++i)
      displays.push_back(get_display(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
  std::erase(displays, EGL_NO_DISPLAY);
  return displays;
}

/// True if the X server of DISPLAY responds and supports OpenGL; otherwise VTK would end the process. Uses
/// dlopen: VTK brings these libraries, and machines without X need none of their headers.
bool x_server_draws() {
  void* x11 = dlopen("libX11.so.6", RTLD_LAZY);
  void* gl = dlopen("libGL.so.1", RTLD_LAZY);
  if (x11 == nullptr || gl == nullptr)
    return false;
  const auto open_display = reinterpret_cast<void* (*)(const char*)>(dlsym(x11, "XOpenDisplay"));
  const auto close_display = reinterpret_cast<int (*)(void*)>(dlsym(x11, "XCloseDisplay"));
  const auto default_screen = reinterpret_cast<int (*)(void*)>(dlsym(x11, "XDefaultScreen"));
  const auto free_memory = reinterpret_cast<int (*)(void*)>(dlsym(x11, "XFree"));
  const auto has_glx = reinterpret_cast<int (*)(void*, int*, int*)>(dlsym(gl, "glXQueryExtension"));
  const auto choose_visual = reinterpret_cast<void* (*)(void*, int, int*)>(dlsym(gl, "glXChooseVisual"));
  if (!open_display || !close_display || !default_screen || !free_memory || !has_glx || !choose_visual)
    return false;
  void* display = open_display(nullptr);
  if (display == nullptr)
    return false;
  constexpr int glx_rgba = 4, glx_depth_size = 12, end = 0;
  std::array<int, 4> wanted{glx_rgba, glx_depth_size, 16, end};
  void* visual = has_glx(display, nullptr, nullptr)
                     ? choose_visual(display, default_screen(display), wanted.data())
                     : nullptr;
  const bool draws = visual != nullptr;
  if (draws)
    free_memory(visual);
  close_display(display);
  return draws;
}

/// Mesa ends the process by a signal if its compiler and threads cannot have their address space; measured,
/// with a margin.
constexpr std::int64_t enough_to_draw = std::int64_t{700} << 20;

void note_error(vtkObject*, unsigned long, void* failed, void*) {
  *static_cast<bool*>(failed) = true;
}

} // namespace

/// A context with a small surface, current during its lifetime.
class OffscreenWindow::EglContext {
public:
  EglContext() = default;
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;
  ~EglContext() {
    if (display_ == EGL_NO_DISPLAY)
      return;
    // The display stays initialised: it belongs to the process, and other code may be drawing.
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
    eglDestroySurface(display_, surface_);
  }

  bool make_current() {
    for (EGLDisplay display : egl_displays())
      if (make_current_on(display))
        return true;
    return false;
  }

private:
  bool make_current_on(EGLDisplay display) {
    EGLConfig config = nullptr;
    EGLint n_configs = 0;
    constexpr std::array<EGLint, 13> wanted{EGL_SURFACE_TYPE,
                                            EGL_PBUFFER_BIT,
                                            EGL_RENDERABLE_TYPE,
                                            EGL_OPENGL_BIT,
                                            EGL_RED_SIZE,
                                            8,
                                            EGL_GREEN_SIZE,
                                            8,
                                            EGL_BLUE_SIZE,
                                            8,
                                            EGL_DEPTH_SIZE,
                                            24,
                                            EGL_NONE};
    if (!eglInitialize(display, nullptr, nullptr) || !eglBindAPI(EGL_OPENGL_API) ||
        !eglChooseConfig(display, wanted.data(), &config, 1, &n_configs) || n_configs == 0)
      return false;
    // VTK draws into its own frame buffers; the surface only completes the context.
    constexpr std::array<EGLint, 5> size{EGL_WIDTH, 16, EGL_HEIGHT, 16, EGL_NONE};
    constexpr std::array<EGLint, 7> version{EGL_CONTEXT_MAJOR_VERSION,
                                            3,
                                            EGL_CONTEXT_MINOR_VERSION,
                                            3,
                                            EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                            EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                            EGL_NONE};
    EGLSurface surface = eglCreatePbufferSurface(display, config, size.data());
    EGLContext context = eglCreateContext(display, config, EGL_NO_CONTEXT, version.data());
    if (surface != EGL_NO_SURFACE && context != EGL_NO_CONTEXT &&
        eglMakeCurrent(display, surface, surface, context)) {
      display_ = display;
      surface_ = surface;
      context_ = context;
      return true;
    }
    if (context != EGL_NO_CONTEXT)
      eglDestroyContext(display, context);
    if (surface != EGL_NO_SURFACE)
      eglDestroySurface(display, surface);
    return false;
  }

  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLSurface surface_ = EGL_NO_SURFACE;
  EGLContext context_ = EGL_NO_CONTEXT;
};

OffscreenWindow::OffscreenWindow() = default;

OffscreenWindow::~OffscreenWindow() {
  if (window_ != nullptr)
    window_->Finalize();
  window_ = nullptr;
}

std::unique_ptr<OffscreenWindow> OffscreenWindow::open(int width, int height, std::string& why_not) {
  if (available_memory() < enough_to_draw) {
    why_not = fmt::format("no picture: drawing may take {}, {} are left",
                          bytes_in_words(static_cast<double>(enough_to_draw)),
                          bytes_in_words(static_cast<double>(available_memory())));
    return nullptr;
  }
  std::unique_ptr<OffscreenWindow> offscreen(new OffscreenWindow);
  std::string why_not_egl, why_not_x;
  if (offscreen->open_with_egl(width, height, why_not_egl) ||
      offscreen->open_with_x(width, height, why_not_x)) {
    offscreen->window().SetMultiSamples(8);
    offscreen->window().SetNumberOfLayers(2);
    return offscreen;
  }
  why_not = "no picture: " + why_not_egl + "; " + why_not_x;
  return nullptr;
}

bool OffscreenWindow::open_with_egl(int width, int height, std::string& why_not) {
  const void* const forgiving = dlsym(RTLD_DEFAULT, "maille_glew_init");
  if (forgiving == nullptr || forgiving != dlsym(RTLD_DEFAULT, "glewInit")) {
    why_not = "EGL needs an executable that exports maille's glewInit";
    return false;
  }
  auto context = std::make_unique<EglContext>();
  if (!context->make_current()) {
    why_not = "EGL gives no OpenGL 3.3 context (libegl1 and libgl1-mesa-dri would)";
    return false;
  }
  vtkNew<vtkGenericOpenGLRenderWindow> window;
  bool failed = false;
  vtkNew<vtkCallbackCommand> listener; // observed errors are not printed
  listener->SetCallback(note_error);
  listener->SetClientData(&failed);
  const unsigned long observer = window->AddObserver("ErrorEvent", listener);
  window->SetOffScreenRendering(1);
  window->SetReadyForRendering(true);
  window->SetSupportsOpenGL(1);
  window->SetIsCurrent(true);
  window->SetSize(width, height);
  window->OpenGLInit();
  window->RemoveObserver(observer); // `failed` ends with this function
  if (failed) {
    why_not = "VTK cannot use the OpenGL context that EGL gives";
    window->Finalize();
    return false;
  }
  context_ = std::move(context);
  window_ = window.Get();
  return true;
}

bool OffscreenWindow::open_with_x(int width, int height, std::string& why_not) {
  if (std::getenv("DISPLAY") == nullptr) {
    why_not = "there is no X server (DISPLAY is not set)";
    return false;
  }
  if (!x_server_draws()) {
    why_not = "the X server that DISPLAY names does not answer or has no OpenGL";
    return false;
  }
  window_ = vtkSmartPointer<vtkRenderWindow>::New();
  window_->SetOffScreenRendering(1);
  window_->SetSize(width, height);
  return true;
}

} // namespace maille::studies
