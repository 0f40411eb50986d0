#include <EGL/egl.h>
#include <dlfcn.h>

// GLEW is built for X here: with an EGL context it loads every OpenGL function and then reports that there is
// no GLX display, which VTK takes for a failure. This definition, exported by the executable (the link
// options of maille_glew_init), comes before GLEW's and ignores that one error. Its second name tells
// offscreen.cpp that it is there. The executable knows EGL by name alone: the creator of the context has
// loaded it.
extern "C" unsigned int maille_glew_init();
extern "C" unsigned int maille_glew_init() {
  constexpr unsigned int ok = 0;
  constexpr unsigned int no_glx_display = 4;
  using Init = unsigned int (*)();
  using Current = EGLContext (*)();
  const auto glew_own = reinterpret_cast<Init>(dlsym(RTLD_NEXT, "glewInit"));
  const auto current = reinterpret_cast<Current>(dlsym(RTLD_DEFAULT, "eglGetCurrentContext"));
  const unsigned int status = glew_own != nullptr ? glew_own() : 1;
  return status == no_glx_display && current != nullptr && current() != EGL_NO_CONTEXT ? ok : status;
}
extern "C" unsigned int glewInit() __attribute__((alias("maille_glew_init")));
