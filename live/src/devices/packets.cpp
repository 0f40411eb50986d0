#include "maille/live/device.hpp"

#include <Eigen/Geometry>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>

namespace maille::live {

namespace {

constexpr double farthest = 1000; // [m]

template<class Value>
Value read_at(std::span<const std::byte> bytes, std::size_t at) {
  static_assert(std::endian::native == std::endian::little, "packets are little endian");
  Value value;
  std::memcpy(&value, bytes.data() + at, sizeof(Value));
  return value;
}

template<class Value>
void write_at(std::span<std::byte> bytes, std::size_t at, Value value) {
  std::memcpy(bytes.data() + at, &value, sizeof(Value));
}

} // namespace

std::optional<HandPacket> parse_hand_packet(std::span<const std::byte> bytes) {
  if (bytes.size() != hand_packet_size || std::memcmp(bytes.data(), "MLH1", 4) != 0)
    return std::nullopt;
  HandPacket packet;
  packet.number = read_at<std::uint32_t>(bytes, 4);
  std::array<double, 4> q{};
  for (std::size_t i = 0; i < 3; ++i)
    packet.pose.position[static_cast<Eigen::Index>(i)] = read_at<double>(bytes, 8 + 8 * i);
  for (std::size_t i = 0; i < 4; ++i)
    q[i] = read_at<double>(bytes, 32 + 8 * i);
  packet.buttons = read_at<std::uint32_t>(bytes, 64);
  const double length = std::hypot(std::hypot(q[0], q[1]), std::hypot(q[2], q[3]));
  if (!packet.pose.position.allFinite() || !(packet.pose.position.norm() < farthest) ||
      !(std::abs(length - 1) < 0.01))
    return std::nullopt;
  packet.pose.rotation = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix();
  return packet;
}

void write_force_packet(std::uint32_t number, const deform::ProbeForce& force,
                        std::span<std::byte, force_packet_size> bytes) {
  std::memcpy(bytes.data(), "MLF1", 4);
  write_at(bytes, 4, number);
  for (std::size_t i = 0; i < 3; ++i) {
    write_at(bytes, 8 + 8 * i, force.force[static_cast<Eigen::Index>(i)]);
    write_at(bytes, 32 + 8 * i, force.torque[static_cast<Eigen::Index>(i)]);
  }
}

} // namespace maille::live
