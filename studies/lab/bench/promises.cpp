#include "bench/subjects.hpp"

#include "checks/promises.hpp"
#include "checks/world_promises.hpp"
#include "compare/methods.hpp"
#include "maille/deform/solve.hpp"
#include "maille/deform/world/trajectory_drives.hpp"
#include "maille/materials/fault.hpp"
#include "maille/scene/block_frames.hpp"
#include "maille/scene/link_limits.hpp"
#include "maille/scene/read_scene.hpp"
#include "maille/scene/world/trajectory.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace maille::lab {

namespace {

constexpr double seconds_budget = 10; ///< that a method is asked to keep

std::string outcome_of(const Answer& answer) {
  return is_converged(answer.status)               ? "settled"
         : answer.status == Status::budget_reached ? "budget reached"
                                                   : std::string(to_string(answer.status));
}

void answer(const Scene& scene, const std::string& method, Control control, nlohmann::ordered_json& row) {
  control.seconds_budget = seconds_budget;
  const Answer answer = answer_by(scene, method, control);
  row["outcome"] = answer.status == Status::clamped ? "clamped" : outcome_of(answer);
  row["note"] = answer.message;
  row["broken"] = broken_promise(scene, method, answer);
  if (method == "limits" && is_converged(answer.status)) {
    const Answer paths = deform::solve(scene, "dijkstra", control);
    if (is_converged(paths.status)) {
      row["error"] = compare(scene, answer.displacement, paths.displacement).relative_max;
      if (!(row["error"] <= 1e-6))
        row["broken"] = "is not what shortest paths answer";
    }
  }
  row["iterations"] = answer.iterations;
  row["seconds"] = answer.seconds.total();
  if (answer.strain_energy)
    row["energy"] = *answer.strain_energy;
  if (has_displacement(answer.status) && !(method == "coupled" && in_blocks(scene)))
    row["violation"] = largest_violation(scene, LinkLimits(scene), answer.displacement, object_frame(scene));
}

void play(const std::filesystem::path& file, const std::filesystem::path& trajectory, const Control& control,
          nlohmann::ordered_json& row) {
  WorldScene scene = read_world_scene(file);
  const Trajectory input = read_trajectory(trajectory, scene);
  apply_settings(input.settings, scene);
  deform::World world(scene);
  deform::TrajectoryDrives drives_of(world);
  std::vector<bool> is_in_hand(scene.objects.size(), false);
  std::int64_t clamped = 0, cut_short = 0, rounds = 0;
  double violation = 0, seconds = 0;
  std::string broken;
  for (std::int64_t frame = 1; frame <= input.n_frames && broken.empty() && !control.should_stop(); ++frame) {
    std::vector<DriveSpan> spans;
    std::ranges::copy_if(input.spans, std::back_inserter(spans), [&](const DriveSpan& span) {
      return span.first_frame <= frame && frame < span.end_frame();
    });
    const auto drives = drives_of.begin_frame(world, spans, frame);
    for (const deform::Drive& drive : drives)
      is_in_hand[static_cast<std::size_t>(drive.object)] = true;
    deform::FrameBudget budget;
    budget.rounds = 200;
    budget.frame_seconds = input.frame_seconds;
    const deform::FrameResult result = world.advance(drives, budget);
    clamped += result.status == Status::clamped;
    cut_short += result.status == Status::budget_reached;
    rounds += result.rounds;
    seconds += result.seconds;
    violation = std::max(violation, world.largest_violation());
    if (broken = broken_promise(world, result, is_in_hand); !broken.empty())
      broken = fmt::format("frame {}: {}", frame, broken);
  }
  row["outcome"] = cut_short > 0 ? "budget reached" : clamped > 0 ? "clamped" : "settled";
  row["note"] = fmt::format("{} frames, {} clamped, {} cut short", input.n_frames, clamped, cut_short);
  row["broken"] = broken;
  row["iterations"] = rounds;
  row["seconds"] = seconds;
  row["violation"] = violation;
}

} // namespace

nlohmann::ordered_json promises_of(const std::filesystem::path& scene, const std::string& method,
                                   const std::filesystem::path& trajectory, const Control& control) {
  nlohmann::ordered_json row{{"method", method}, {"outcome", "failed"}, {"broken", ""}};
  try {
    trajectory.empty() ? answer(read_scene(scene), method, control, row)
                       : play(scene, trajectory, control, row);
  } catch (const InputError& error) {
    row["outcome"] = "refused";
    row["note"] = "by the reader: " + to_string(error.faults().at(0));
  } catch (const std::exception& error) {
    row["broken"] = fmt::format("an exception came out: {}", error.what());
  }
  return row;
}

} // namespace maille::lab
