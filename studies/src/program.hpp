#pragma once
/// Running of other programs, which may be missing.

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace maille::studies {

/// The text as one word of a shell's command line, in single quotes.
std::string shell_word(std::string_view text);

/// True if the shell finds a program of that name.
bool has_program(std::string_view name);

/// Runs a shell command line and polls `should_stop` several times in a tenth of a second; on a stop request,
/// kills it with all its children.
/// @return its exit code, 128 + N if signal N ended it, 127 if it cannot be started; nothing if it was killed
///         on request
std::optional<int> run_program(const std::string& line, const std::function<bool()>& should_stop = {});

/// Kills all running programs with their children, and every later one. Safe in a signal handler.
void end_programs() noexcept;

} // namespace maille::studies
