#pragma once
/// Text files, read whole or not at all.

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace maille {

/// What a scene, a material or a study that somebody wrote stays far below [bytes]. As TOML it takes some
/// sixty times its size.
inline constexpr std::int64_t largest_written_text = std::int64_t{16} << 20;

/// The content of a file or a pipe.
/// @param what    it is to be, for the message: "a scene file"
/// @param largest that is read [bytes]: a device has no end
/// @throws InputError  nothing there that can be read; an error of the device on the way (the part that was
///                     read is not the file); more bytes than `largest`
std::string read_text_file(const std::filesystem::path& file, std::string_view what,
                           std::int64_t largest = largest_written_text);

} // namespace maille
