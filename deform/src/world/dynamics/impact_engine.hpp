#pragma once
/// Rigid objects in time: free flight, impacts, resting contact.
///
/// step() advances all objects in free flight in closed form (constant gravity; no object moves further than
/// a part of a cell). It finds the first contact by bisection to within the skin, and changes velocities
/// there by impulses: Newton's law of restitution, with Coulomb friction (resolve_impacts). Impulses without
/// restitution support resting objects, once a step. Driven objects have infinite mass and follow their
/// motions; a driven object that is jammed against a wall stops.

#include "world/balance/surface_engine.hpp"
#include "world/dynamics/impacts.hpp"
#include "world/dynamics/moving_object.hpp"

#include <cstdint>
#include <map>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

namespace maille::deform {

/// A driven object during a frame.
struct LedObject {
  int object = 0;
  RigidMotion motion; ///< of the whole frame
  Pose from;          ///< initial pose
  double done = 0;    ///< finished part of the motion
  bool is_stopped = false;
};

class ImpactEngine : public SurfaceEngine {
public:
  explicit ImpactEngine(std::unique_ptr<WorldObjects> world);

  bool is_settled() const override { return false; } ///< time advances
  ObjectMotion motion(int object) const override;
  /// Kinetic energy, and potential energy above the world's corner [J].
  double energy() const override;

private:
  void move(SurfaceFrame& surfaces) override;
  /// Sets the driven objects, before a frame.
  void hold(std::span<LedObject> led, double seconds);
  /// Sets the velocity of an object to zero.
  void stop(int object);
  /// Advances by at most `most` [s]; led objects follow their motions. @return the time advanced [s]
  double step(std::span<LedObject> led, double most, double seconds);
  bool has_moved(const Balance::State& since) const;
  void report(FrameRun& frame, std::span<const LedObject> led);

  /// Impulses on the surfaces of objects in a frame. Keys: object, other object, voxel of the first one's
  /// skin.
  struct Impulse {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero(); ///< on the object [N s]
    Eigen::Vector3d at = Eigen::Vector3d::Zero();  ///< place of the last impulse [m]
  };
  struct State {
    std::vector<Pose> poses;
    std::vector<MovingObject> moving;
  };
  State state() const;
  void put(const State& state);
  /// Updates the touches. @return the smallest gap [m]
  double look();
  double least_gap() const; ///< of the last look() [m]
  std::vector<ImpactPoint> points(double within) const;
  void resolve(std::span<ImpactPoint> points, std::vector<MovingObject>& moving, double restitution,
               std::span<LedObject> led);
  void keep(std::span<const ImpactPoint> points);
  State moved(const State& from, std::span<const char> lies, std::span<const LedObject> led, double time,
              double seconds) const;
  double longest_step(double most) const;
  void part_overlaps();
  double skin() const;

  Fall fall_;
  double restitution_;
  std::vector<MovingObject> moving_; ///< by object
  std::map<std::tuple<int, int, std::int32_t>, Impulse> impulses_;
};

} // namespace maille::deform
