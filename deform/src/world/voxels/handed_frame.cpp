/// A frame of a world whose voxels hand on what they cannot move.

#include "lattice/tolerances.hpp"
#include "world/voxels/single_voxels.hpp"
#include "world/world_frame.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

namespace maille::deform {

namespace {

void add_hand_overs(const SingleVoxels::Handed& handed, const Vec3& cell_size,
                    std::vector<HandOver>& hand_overs) {
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(handed.asked[axis]) > tolerance) {
      const double size = cell_size[static_cast<std::size_t>(axis)];
      hand_overs.push_back({handed.from.object, handed.from.voxel, handed.to.object, handed.to.voxel, axis,
                            handed.asked[axis] * size, handed.moved[axis] * size});
    }
}

} // namespace

/// Steps of a cell: hands first, then the sweeps that each body has a frame, or until nothing moves.
FrameResult WorldFrame::run_handed_on() {
  for (const Drive& drive : drives_)
    if (drive.lead || (!parts_.is_body(drive.object) && drive.motion.angle != 0))
      throw std::invalid_argument(
          "Drive: the method `hand_on` shifts rigid objects, without turns or a spring");
  take_handles();
  SingleVoxels voxels(parts_);
  const int n = std::min(n_steps(), 1'000'000);
  if (!clock_.rounds_left)
    clock_.rounds_left = std::int64_t{n} * iteration_cap;
  bool has_settled = true;
  for (int step = 0; step < n && clock_.may_go_on(); ++step) {
    result_.contacts.clear();
    for (std::size_t i = 0; i < drives_.size(); ++i)
      drive_voxels(i, step, n, voxels);
    has_settled = sweep_to_rest(voxels);
  }
  voxels.hand_back(parts_);
  for (DeformableObject& body : parts_.bodies)
    body.settle_handles();
  for (std::size_t i = 0; i < drives_.size(); ++i)
    report_drive(i);
  report_end(has_settled, "bodies are on their way to rest", "bodies are on their way to rest");
  for (int object = 0; object < parts_.n_objects(); ++object)
    parts_.member(object).is_unsettled = parts_.is_body(object) && !is_converged(result_.status);
  return std::move(result_);
}

void WorldFrame::drive_voxels(std::size_t i, int step, int n, SingleVoxels& voxels) {
  const Drive& drive = drives_[i];
  const Eigen::Vector3d size = Eigen::Vector3d::Map(parts_.scene.spacing.data());
  const RigidMotion before = part_of(drive.motion, 0, static_cast<double>(step) / n),
                    after = part_of(drive.motion, 0, (step + 1.0) / n);
  if (!parts_.is_body(drive.object)) {
    rigid_done_[i] += voxels.move_rigid(drive.object, (drive.motion.by / n).cwiseQuotient(size)) / n;
  } else {
    std::vector<Eigen::Vector3d> by;
    for (const Eigen::Vector3d& from : nodes_before_[i])
      by.push_back((moved_point(after, from) - moved_point(before, from)).cwiseQuotient(size));
    voxels.move_nodes(drive.object, drive.nodes, by);
  }
  for (const SingleVoxels::Handed& handed : voxels.take_handed()) {
    add_hand_overs(handed, parts_.scene.spacing, result_.handed_on);
    report_handed(handed);
  }
}

/// @return whether nothing moves any more
bool WorldFrame::sweep_to_rest(SingleVoxels& voxels) {
  std::vector<SingleVoxels::Handed> handed; // by the last sweep
  bool has_settled = parts_.bodies.empty(), is_over = has_settled;
  for (std::int64_t sweep = 0; !is_over && clock_.may_go_on(); ++sweep) {
    ++clock_.rounds;
    if (clock_.rounds_left)
      --*clock_.rounds_left;
    double furthest = 0;
    is_over = true;
    for (int object = 0; object < parts_.n_objects(); ++object)
      if (parts_.is_body(object) && sweep < parts_.body(object).scene().relaxation.sweeps) {
        is_over = false;
        furthest = std::max(furthest, voxels.sweep(object));
      }
    if (is_over)
      break;
    handed = voxels.take_handed();
    std::erase_if(handed, [](const SingleVoxels::Handed& one) { return one.from.object == one.to.object; });
    for (const SingleVoxels::Handed& one : handed)
      add_hand_overs(one, parts_.scene.spacing, result_.handed_on);
    has_settled = is_over = furthest < negligible;
  }
  std::ranges::for_each(handed, [&](const auto& one) { report_handed(one); });
  return has_settled;
}

/// What still wants to go on at the end of a frame touches what it would hand that to.
void WorldFrame::report_handed(const SingleVoxels::Handed& handed) {
  if (handed.from.object == handed.to.object)
    return;
  WorldContact contact;
  contact.object = handed.from.object;
  contact.voxel = handed.from.voxel;
  contact.other = handed.to.object;
  contact.other_voxel = handed.to.voxel;
  set_axis(contact, -handed.asked);
  result_.contacts.push_back(contact);
}

} // namespace maille::deform
