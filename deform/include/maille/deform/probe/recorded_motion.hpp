#pragma once
/// A hand's movement, recorded.

#include "maille/deform/world/rigid_shape.hpp"

#include <filesystem>
#include <string_view>
#include <vector>

namespace maille::deform {

/// Poses of a handle at times; between them positions go along straight lines and turns about one axis, evenly.
class RecordedMotion {
public:
  struct Sample {
    double time = 0; ///< [s], rising from sample to sample
    Pose pose;       ///< of the handle's point, in the world
  };
  /// @throws std::invalid_argument where there is no sample, or times do not rise
  explicit RecordedMotion(std::vector<Sample> samples);

  /// Before the first and after the last sample: that one.
  Pose at(double time) const;
  double duration() const { return samples_.back().time; }
  const std::vector<Sample>& samples() const { return samples_; }

private:
  std::vector<Sample> samples_;
};

/// Reads lines `time,x,y,z` or `time,x,y,z,turn_x,turn_y,turn_z` under a line with just these names: seconds, metres in the world, and an
/// axis times an angle in radians; a name may be followed by another unit in brackets, as in `x [mm]`. Empty lines and what follows a # are passed over.
/// @throws InputError with every fault; a file that cannot be read, or of more than 256 MiB (a device has no end)
RecordedMotion read_recorded_motion(const std::filesystem::path& file);
/// The same from text; `file` gives the name for messages.
RecordedMotion parse_recorded_motion(std::string_view text, const std::string& file = "motion.csv");

} // namespace maille::deform
