#include <csignal>

// METIS catches SIGABRT, by which its own memory ends, and SIGTERM while it orders: who asks the program to
// end then is not heard, and in a thread that is not METIS's own its handler jumps to nowhere. It does so by
// this function, which nothing else uses. This definition, exported by the executable (the link options of
// maille_metis_signals), comes before the C library's, and leaves SIGTERM to the program.
extern "C" __sighandler_t __sysv_signal(int number, __sighandler_t handler) noexcept {
  if (number == SIGTERM)
    return SIG_DFL; // METIS hands it back when it is done, with the same effect
  struct sigaction wanted {};
  struct sigaction before {};
  wanted.sa_handler = handler;
  wanted.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER); // what System V did
  return sigaction(number, &wanted, &before) == 0 ? before.sa_handler : SIG_ERR;
}
