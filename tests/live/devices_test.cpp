/// Hands of six degrees of freedom: packets, devices that vanish.

#include "live/by_hand.hpp"
#include "support/kit.hpp"

#include <Eigen/Geometry>

#include <arpa/inet.h>
#include <chrono>
#include <cstring>
#include <netinet/in.h>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>

namespace maille::live {
namespace {

using test::write_hand_packet;

HandPacket some_packet() {
  HandPacket packet;
  packet.number = 7;
  packet.pose.position = {0.1, -0.2, 0.3};
  packet.pose.rotation = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  packet.buttons = 5;
  return packet;
}

TEST(LiveDevicesContract, APacketIsReadAsItWasWritten) {
  std::array<std::byte, hand_packet_size> bytes{};
  write_hand_packet(some_packet(), bytes);
  const auto read = parse_hand_packet(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->number, 7u);
  EXPECT_EQ(read->buttons, 5u);
  EXPECT_EQ(read->pose.position, some_packet().pose.position);
  EXPECT_NEAR((read->pose.rotation - some_packet().pose.rotation).norm(), 0, 1e-14);
}

TEST(LiveDevicesContract, WhatIsNoPacketIsNone) {
  std::array<std::byte, hand_packet_size> good{};
  write_hand_packet(some_packet(), good);
  EXPECT_FALSE(parse_hand_packet(std::span(good).first(71)));
  EXPECT_FALSE(parse_hand_packet({}));
  auto bytes = good;
  bytes[0] = std::byte{'X'};
  EXPECT_FALSE(parse_hand_packet(bytes));
  for (const double bad : {std::nan(""), 1e300 * 1e300, 1e9}) {
    bytes = good;
    std::memcpy(bytes.data() + 8, &bad, sizeof(bad));
    EXPECT_FALSE(parse_hand_packet(bytes)) << bad;
    bytes = good;
    std::memcpy(bytes.data() + 40, &bad, sizeof(bad)); // of the quaternion
    EXPECT_FALSE(parse_hand_packet(bytes)) << bad;
  }
  std::mt19937 random(11);
  for (int i = 0; i < 2000; ++i) {
    std::vector<std::byte> noise(random() % 160);
    for (std::byte& byte : noise)
      byte = static_cast<std::byte>(random() & 255);
    if (noise.size() > 4 && i % 2 == 0)
      std::memcpy(noise.data(), "MLH1", 4);
    if (const auto packet = parse_hand_packet(noise)) {
      EXPECT_TRUE(packet->pose.position.allFinite());
      EXPECT_NEAR(packet->pose.rotation.determinant(), 1, 1e-9);
    }
  }
}

/// A third-party device program.
class Sender {
public:
  explicit Sender(int port) : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
    to_.sin_family = AF_INET;
    to_.sin_port = htons(static_cast<std::uint16_t>(port));
    to_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  }
  ~Sender() { ::close(socket_); }
  void send(std::span<const std::byte> bytes) {
    ::sendto(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to_), sizeof(to_));
  }
  /// How many bytes came back.
  long receive(std::span<std::byte> bytes) { return ::recv(socket_, bytes.data(), bytes.size(), 0); }

private:
  int socket_;
  sockaddr_in to_{};
};

constexpr int port = 47913;

TEST(LiveDevicesContract, AUdpDeviceIsReadAnsweredAndLost) {
  const auto device = udp_device(port);
  EXPECT_THROW(udp_device(port), std::runtime_error); // the port is taken
  EXPECT_FALSE(device->read().is_there);
  Sender sender(port);
  sender.send(std::as_bytes(std::span("what is this?")));
  std::array<std::byte, hand_packet_size> bytes{};
  write_hand_packet(some_packet(), bytes);
  sender.send(bytes);
  const DeviceState state = device->read();
  ASSERT_TRUE(state.is_there);
  EXPECT_EQ(state.pose->position, some_packet().pose.position);
  EXPECT_TRUE(test::has(device->status(), "1 malformed"));
  device->write({{1, 2, 3}, {0, 0, 0}});
  std::array<std::byte, 128> answer{};
  ASSERT_EQ(sender.receive(answer), static_cast<long>(force_packet_size));
  double force = 0;
  std::memcpy(&force, answer.data() + 16, sizeof(force));
  EXPECT_EQ(std::memcmp(answer.data(), "MLF1", 4), 0);
  EXPECT_EQ(force, 2);
  std::this_thread::sleep_for(std::chrono::milliseconds(600));
  EXPECT_FALSE(device->read().is_there);
  EXPECT_TRUE(test::has(device->status(), "lost"));
}

// A device moves what is held, and what it has held stays where it is when the device is gone.
TEST(LiveDevicesContract, WhatADeviceHoldsStaysWhereItIsWhenItVanishes) {
  const WorldScene scene = read_world_scene(test::world_folder / "muscle.toml");
  Session session(scene, {});
  auto device = std::make_shared<GamePad>(0.05);
  session.use(device);
  device->set("leftx", 1);
  session.grip({1, {}}, 1);
  const auto begin = session.state()->frames[1].position;
  for (int i = 0; i < 400 && session.state()->frames[1].position[0] < begin[0] + 2e-3; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_GT(session.state()->frames[1].position[0], begin[0] + 1e-3);
  device->lose();
  ASSERT_TRUE(session.wait_idle(20));
  const auto left = session.state()->frames[1].position;
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  EXPECT_EQ(session.state()->frames[1].position, left);
  session.let_go(true, 2);
  ASSERT_TRUE(session.wait_idle(20));
  EXPECT_EQ(session.state()->frames[1].position, left);
  EXPECT_EQ(session.n_penetrations(), 0);
}

} // namespace
} // namespace maille::live
