#pragma once
/// Ctrl-C (SIGINT), `timeout`, `scancel` and systemd (SIGTERM), closed terminals (SIGHUP): all three ask the
/// process to end.

namespace maille::studies {

/// Until hear_stop_signals() such a signal ends the process at once; files that are only half written are
/// removed. A SIGHUP that the caller had ignored (nohup) stays ignored. To be called first thing.
void catch_stop_signals();
/// From now on the first of them is only noted; a second one, more than 0.2 s later, ends the process.
void hear_stop_signals();
/// Whether one has been noted.
bool is_stop_asked();
/// Ends the process with what the C library's buffers hold written, without the clean-up of libraries where
/// one of them is still at work in a thread that was left behind. @return `exit_code` where there is none
int leave(int exit_code);

} // namespace maille::studies
