/// For builds with the address sanitizer: OpenMPI loses some hundred kilobytes of its own, from modules that
/// it has unloaded by the end, where no suppression can name them. For the command, and tests that run
/// fem_ref's CG, to link in.

extern "C" const char* __asan_default_options();

extern "C" const char* __asan_default_options() {
  return "detect_leaks=0";
}
