#include <EGL/egl.h>
#include <dlfcn.h>

// GLEW is built for X here: with an EGL context it loads every OpenGL function and then reports that there is
// no GLX display, which VTK treats as a failure. This definition, exported by the executable (link options of
// maille_glew_init), precedes GLEW's and ignores that one error. offscreen.cpp detects it by its second name.
// The executable finds EGL by name only: creating the context has loaded it.
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
