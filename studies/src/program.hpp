#pragma once
/// Other programs, which need not be there.

#include <string>
#include <string_view>

namespace maille::studies {

/// The text as one word of a shell's command line, in single quotes.
std::string shell_word(std::string_view text);

/// Whether the shell finds a program of that name.
bool has_program(std::string_view name);

} // namespace maille::studies
