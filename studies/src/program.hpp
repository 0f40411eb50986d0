#pragma once
/// Other programs, which need not be there.

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace maille::studies {

/// The text as one word of a shell's command line, in single quotes.
std::string shell_word(std::string_view text);

/// Whether the shell finds a program of that name.
bool has_program(std::string_view name);

/// Runs a line of the shell and asks some times in a tenth of a second whether to stop; then it is killed
/// with all that it has started.
/// @return its exit code, 128 + N where signal N ended it, 127 where it cannot be started; nothing where it
///         was killed on demand
std::optional<int> run_program(const std::string& line, const std::function<bool()>& should_stop = {});

/// Kills all programs that are running, with all that they have started, and every later one. A signal
/// handler may call it.
void end_programs() noexcept;

} // namespace maille::studies
