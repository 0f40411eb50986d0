#include <csignal>

// While ordering, METIS catches SIGABRT, which signals its own lack of memory, and SIGTERM: a request to end
// the program is then lost, and in a thread not owned by METIS its handler jumps to an invalid address. METIS
// installs handlers by this function, which has no other user. This definition, exported by the executable
// (link options of maille_metis_signals), precedes the C library's and leaves SIGTERM to the program.
extern "C" __sighandler_t __sysv_signal(int number, __sighandler_t handler) noexcept {
  if (number == SIGTERM)
    return SIG_DFL; // METIS restores this value in the end, with the same effect
  struct sigaction wanted {};
  struct sigaction before {};
  wanted.sa_handler = handler;
  wanted.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER); // behaviour of System V
  return sigaction(number, &wanted, &before) == 0 ? before.sa_handler : SIG_ERR;
}
