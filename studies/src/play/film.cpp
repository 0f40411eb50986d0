#include "export/whole_file.hpp"
#include "play/play.hpp"
#include "program.hpp"

#include <fmt/format.h>

namespace maille::studies {

namespace {

/// Escapes % in names, which ffmpeg would replace by a number.
std::string with_percents_doubled(const std::string& text) {
  std::string doubled;
  for (const char c : text)
    doubled += c == '%' ? std::string("%%") : std::string(1, c);
  return doubled;
}

} // namespace

bool has_ffmpeg() {
  return has_program("ffmpeg");
}

std::optional<std::string> make_film(const std::filesystem::path& stem, int n_digits, std::int64_t n_pictures,
                                     double frame_seconds, const std::filesystem::path& mp4) {
  if (!has_ffmpeg())
    return "no film: there is no `ffmpeg` to run";
  int status = 0;
  try {
    write_whole(mp4, [&](const std::filesystem::path& file) {
      // Absolute paths with `file:`, so that a name is neither an option nor a protocol.
      const std::string pictures = "file:" + with_percents_doubled(std::filesystem::absolute(stem).string()) +
                                   fmt::format("_%0{}d.png", n_digits),
                        film = "file:" + std::filesystem::absolute(file).string();
      status =
          run_program(fmt::format("ffmpeg -nostdin -y -loglevel error -framerate {} -i {} -frames:v {} "
                                  "-vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2:0:0:white' " // H.264 wants even sides
                                  "-c:v libx264 -crf 20 -pix_fmt "
                                  "yuv420p -movflags +faststart {} > /dev/null 2>&1",
                                  1 / frame_seconds, shell_word(pictures), n_pictures, shell_word(film)))
              .value_or(1);
      if (status != 0)
        throw std::runtime_error("ffmpeg failed");
    });
  } catch (const std::runtime_error& error) {
    return fmt::format("no film: {}",
                       status != 0 ? fmt::format("ffmpeg ended with status {}", status) : message_of(error));
  }
  return std::nullopt;
}

} // namespace maille::studies
