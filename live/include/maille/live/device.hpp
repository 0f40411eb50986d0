#pragma once
/// Input devices of six degrees of freedom, in addition to the mouse.

#include "maille/deform/probe/device.hpp"

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>

namespace maille::live {

/// State of a device in one tick.
struct DeviceState {
  bool is_there = false; ///< false: not connected yet, or disconnected
  /// Position devices: the handle's position [m] and rotation, in the device's frame.
  std::optional<deform::Pose> pose;
  /// Rate devices: velocity [m/s] and angular velocity [rad/s], in the world.
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero(), turning = Eigen::Vector3d::Zero();
  std::uint32_t buttons = 0; ///< bit 0: hold
};

/// The hand loop calls read and write once per tick; neither blocks.
class HandDevice {
public:
  virtual ~HandDevice() = default;
  virtual DeviceState read() = 0;
  virtual void write(const deform::ProbeForce& force) = 0;
  /// Connection state, in words.
  virtual std::string status() const = 0;
};

/// The packet from the program of a haptic device, 72 bytes, little endian: the letters `MLH1`, an increasing
/// number, position x y z [m], orientation as a unit quaternion w x y z (to 1 %), buttons, zero.
struct HandPacket {
  std::uint32_t number = 0;
  deform::Pose pose;
  std::uint32_t buttons = 0;
};
inline constexpr std::size_t hand_packet_size = 72;
/// The reply at each tick, 56 bytes: `MLF1`, the number of the last accepted packet, force x y z [N], torque
/// x y z [N m].
inline constexpr std::size_t force_packet_size = 56;

/// Parses a packet. Nothing for an invalid one: wrong length or header, non-finite numbers, a position beyond
/// a kilometre, a quaternion of length 0.
std::optional<HandPacket> parse_hand_packet(std::span<const std::byte> bytes);
void write_force_packet(std::uint32_t number, const deform::ProbeForce& force,
                        std::span<std::byte, force_packet_size> bytes);

/// Listens on a local port (127.0.0.1 only) and replies to the sender of the last valid packet. The device
/// counts as disconnected half a second after its last packet.
/// @throws std::runtime_error if the port is not available
std::unique_ptr<HandDevice> udp_device(int port);
/// A SpaceMouse via its daemon (spacenavd). @throws std::runtime_error without the daemon, or in builds
/// without libspnav
std::unique_ptr<HandDevice> space_mouse(double metres_a_second);

/// A game controller: the window delivers its axes as events.
class GamePad : public HandDevice {
public:
  explicit GamePad(double metres_a_second) : speed_(metres_a_second) {}
  /// @param axis name in the window's events: `leftx`, `lefty`, `rightx`, `righty`, `triggerleft`,
  ///        `triggerright`, `a`
  void set(const std::string& axis, double value);
  void lose();
  DeviceState read() override;
  void write(const deform::ProbeForce&) override {}
  std::string status() const override;

private:
  double speed_;
  mutable std::mutex lock_; ///< locked only to copy a few numbers: the window's thread sets, the hand's reads
  std::map<std::string, double> axes_;
  bool is_there_ = false, was_lost_ = false;
};

} // namespace maille::live
