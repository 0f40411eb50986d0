#pragma once
/// What holds the hand: devices of six degrees of freedom beside the mouse.

#include "maille/deform/probe/device.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

namespace maille::live {

/// What a device says in a tick.
struct DeviceState {
  bool is_there = false; ///< false: not yet, or no more
  /// For devices with a position: the handle's place [m] and rotation, in the device's own frame.
  std::optional<deform::Pose> pose;
  /// For devices with a speed: [m/s] and rotation [rad/s], in the world.
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero(), turning = Eigen::Vector3d::Zero();
  std::uint32_t buttons = 0; ///< bit 0: hold
};

/// Read and written by the hand's loop, once a tick each; neither waits.
class HandDevice {
public:
  virtual ~HandDevice() = default;
  virtual DeviceState read() = 0;
  virtual void write(const deform::ProbeForce& force) = 0;
  /// In words, with what has become of it.
  virtual std::string status() const = 0;
};

/// The packet that a program of a haptic device sends, 72 bytes, little endian: the letters `MLH1`, a number
/// that rises, position x y z [m], orientation as a quaternion w x y z of length 1 (to 1 %), buttons, zero.
struct HandPacket {
  std::uint32_t number = 0;
  deform::Pose pose;
  std::uint32_t buttons = 0;
};
inline constexpr std::size_t hand_packet_size = 72;
/// The packet that comes back at each tick, 56 bytes: `MLF1`, the number of the last packet taken, force x
/// y z [N], torque x y z [N m].
inline constexpr std::size_t force_packet_size = 56;

/// Nothing for an invalid packet: another length or beginning, numbers that are not finite, a place farther
/// than a kilometre, a quaternion of length 0.
std::optional<HandPacket> parse_hand_packet(std::span<const std::byte> bytes);
void write_hand_packet(const HandPacket& packet, std::span<std::byte, hand_packet_size> bytes);
void write_force_packet(std::uint32_t number, const deform::ProbeForce& force,
                        std::span<std::byte, force_packet_size> bytes);

/// Listens on a port of this machine alone (127.0.0.1) and answers the sender of the last valid packet. The
/// device counts as gone half a second after its last packet.
/// @throws std::runtime_error where the port cannot be had
std::unique_ptr<HandDevice> udp_device(int port);
/// A SpaceMouse by its daemon (spacenavd). @throws std::runtime_error without the daemon, or in builds
/// without libspnav
std::unique_ptr<HandDevice> space_mouse(double metres_a_second);

/// A game controller: its axes come as events of the window.
class GamePad : public HandDevice {
public:
  explicit GamePad(double metres_a_second) : speed_(metres_a_second) {}
  ~GamePad() override;
  /// @param axis as of the window's events: `leftx`, `lefty`, `rightx`, `righty`, `triggerleft`,
  ///        `triggerright`, `a`
  void set(const std::string& axis, double value);
  void lose();
  DeviceState read() override;
  void write(const deform::ProbeForce&) override {}
  std::string status() const override;

private:
  struct Axes;
  double speed_;
  std::shared_ptr<Axes> axes_ = make_axes();
  static std::shared_ptr<Axes> make_axes();
};

} // namespace maille::live
