// Worlds of several objects, frame by frame.

#include "binding.hpp"
#include "maille/deform/world/trajectory_drives.hpp"
#include "maille/scene/plausibility.hpp"
#include "maille/scene/world/trajectory.hpp"
#include "maille/scene/world/world_scene.hpp"

#include <Eigen/Geometry>

#include <atomic>
#include <cstdint>

namespace maille::python {

namespace {

Vec3 triple(const Eigen::Vector3d& v) {
  return {v[0], v[1], v[2]};
}

/// A trajectory, and the world that its objects and nodes are of.
struct RecordedInput {
  Trajectory trajectory;
  std::uint64_t world = 0;
};

/// A world, and where it was before its first frame.
class WorldHandle {
public:
  explicit WorldHandle(const std::string& file) : world_(read_world_scene(file)), drives_(world_) {}

  const WorldScene& scene() const { return world_.scene(); }
  std::uint64_t id() const { return id_; }
  int object(const std::string& name) const {
    for (std::size_t i = 0; i < scene().objects.size(); ++i)
      if (scene().objects[i].name == name)
        return static_cast<int>(i);
    throw py::key_error("expected an object of the world, found \"" + name + "\"");
  }

  /// @param asked of each: name, nodes, by, axis, angle, about (None: the middle of its box), slide
  py::dict advance(const py::list& asked, int threads, std::optional<double> seconds) {
    const SoleUse use(is_used_, "World");
    std::vector<deform::Drive> drives;
    for (const py::handle one : asked) {
      const auto& [name, nodes, by, axis, angle, about, slide] =
          one.cast<std::tuple<std::string, std::vector<std::int64_t>, Vec3, Vec3, double, std::optional<Vec3>,
                              bool>>();
      require_finite("by", by);
      require_finite("axis", axis);
      require_finite("angle", angle);
      require_finite("about", about.value_or(Vec3{}));
      DriveSpan span;
      span.object = static_cast<std::size_t>(object(name));
      span.nodes = nodes;
      span.by = by;
      span.axis = axis;
      span.angle = angle;
      span.about = about;
      span.slide = slide;
      drives.push_back(drives_.drive(world_, span, 1));
    }
    return played(drives, threads, seconds);
  }

  void release(const std::string& name) {
    const SoleUse use(is_used_, "World");
    world_.release(object(name));
  }

  /// The next frame of a recorded input, whose spans have part in it.
  py::dict play(const RecordedInput& input, std::int64_t frame, int threads) {
    const SoleUse use(is_used_, "World");
    if (input.world != id_)
      throw py::value_error("expected a trajectory that was read for this world");
    const Trajectory& trajectory = input.trajectory;
    std::vector<DriveSpan> active;
    for (const DriveSpan& span : trajectory.spans)
      if (span.first_frame <= frame && frame < span.end_frame())
        active.push_back(span);
    const auto drives = drives_.begin_frame(world_, active, frame);
    return played(drives, threads, scene().frame_budget);
  }

  py::array displacement(const std::string& name) const {
    const SoleUse use(is_used_, "World");
    const int number = object(name);
    if (world_.kind(number) != ObjectKind::deformable)
      throw py::value_error("expected a deformable object, found \"" + name + "\"");
    const Grid& grid = scene().objects[number].scene.specimen.grid;
    auto* const state = new Displacement(world_.displacement(number)); // the world goes on
    const py::capsule owner(state, [](void* kept) { delete static_cast<Displacement*>(kept); });
    return displacement_view(owner, grid, *state);
  }
  /// Rows of the matrix from an object's frame, as its shape has it, to the world [m].
  std::array<std::array<double, 4>, 4> pose(const std::string& name) const {
    const SoleUse use(is_used_, "World");
    const deform::Pose now = drives_.frame_now(world_, static_cast<std::size_t>(object(name)));
    std::array<std::array<double, 4>, 4> rows{};
    rows[3][3] = 1;
    for (std::size_t r = 0; r < 3; ++r) {
      rows[r][3] = now.position[static_cast<Eigen::Index>(r)];
      for (std::size_t a = 0; a < 3; ++a)
        rows[r][a] = now.rotation(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(a));
    }
    return rows;
  }

private:
  py::dict played(const std::vector<deform::Drive>& drives, int threads, std::optional<double> seconds) {
    Steering steering(threads, {}, {}, py::none());
    deform::FrameBudget budget;
    budget.seconds = seconds;
    budget.threads = threads;
    budget.stop_requested = steering.control().stop_requested;
    deform::FrameResult result;
    std::int64_t penetrations = 0;
    {
      const py::gil_scoped_release unlocked;
      result = world_.advance(drives, budget);
      penetrations = result.contacts.empty() ? 0 : world_.n_penetrations();
    }
    steering.finish();
    py::dict out;
    out["status"] = std::string(to_string(result.status));
    out["message"] = result.message;
    out["seconds"] = result.seconds;
    out["rounds"] = result.rounds;
    out["motion_left"] = result.motion_left;
    out["force_left"] = result.force_left;
    py::list done;
    for (std::size_t i = 0; i < result.drives.size(); ++i) {
      py::dict drive;
      drive["object"] = scene().objects[drives[i].object].name;
      drive["fraction"] = result.drives[i].fraction;
      drive["force"] = triple(result.drives[i].force);
      done.append(drive);
    }
    out["drives"] = done;
    py::list contacts;
    for (const deform::WorldContact& contact : result.contacts) {
      py::dict record;
      record["object"] = scene().objects[contact.object].name;
      record["other"] = contact.other < 0 ? std::string() : scene().objects[contact.other].name;
      record["voxel"] = contact.voxel;
      record["axis"] = contact.axis;
      record["direction"] = contact.direction;
      record["force"] = triple(contact.force);
      contacts.append(record);
    }
    out["contacts"] = contacts;
    out["penetrations"] = penetrations;
    out["handed_on"] = result.handed_on.size();
    return out;
  }

  static inline std::atomic<std::uint64_t> n_made_{0};

  deform::World world_;
  deform::TrajectoryDrives drives_;
  std::uint64_t id_ = ++n_made_; ///< of a world that is gone, none has it again
  mutable std::atomic<bool> is_used_{false};
};

} // namespace

void bind_worlds(py::module_& module) {
  py::class_<RecordedInput>(module, "Trajectory")
      .def(py::init([](const std::string& file, const WorldHandle& world) {
        return RecordedInput{read_trajectory(file, world.scene()), world.id()};
      }))
      .def_property_readonly("name", [](const RecordedInput& i) { return i.trajectory.name; })
      .def_property_readonly("frame_seconds",
                             [](const RecordedInput& i) { return i.trajectory.frame_seconds; })
      .def_property_readonly("n_frames", [](const RecordedInput& i) { return i.trajectory.n_frames; });
  py::class_<WorldHandle>(module, "World")
      .def(py::init<const std::string&>())
      .def_property_readonly("name", [](const WorldHandle& w) { return w.scene().name; })
      .def_property_readonly("title", [](const WorldHandle& w) { return w.scene().title; })
      .def_property_readonly("warnings", [](const WorldHandle& w) { return world_warnings(w.scene()); })
      .def_property_readonly("dimension", [](const WorldHandle& w) { return w.scene().dimension; })
      .def_property_readonly("cells", [](const WorldHandle& w) { return w.scene().cells; })
      .def_property_readonly("spacing", [](const WorldHandle& w) { return w.scene().spacing; })
      .def_property_readonly("objects",
                             [](const WorldHandle& w) {
                               constexpr const char* kinds[] = {"fixed", "rigid", "deformable"};
                               std::vector<std::pair<std::string, std::string>> list;
                               for (const WorldObject& object : w.scene().objects)
                                 list.emplace_back(object.name, kinds[static_cast<int>(object.kind)]);
                               return list;
                             })
      .def("advance", &WorldHandle::advance)
      .def("release", &WorldHandle::release)
      .def("play", &WorldHandle::play)
      .def("displacement", &WorldHandle::displacement)
      .def("pose", &WorldHandle::pose);
}

} // namespace maille::python
