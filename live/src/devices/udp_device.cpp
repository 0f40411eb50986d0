#include "maille/live/device.hpp"

#include <fmt/format.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <memory>
#include <span>
#include <stdexcept>
#include <string>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace maille::live {

namespace {

constexpr std::chrono::milliseconds lost_after{500};
/// Upper bound of packets per tick: a flooded port must not stall the loop.
constexpr int most_a_tick = 16;

class UdpDevice : public HandDevice {
public:
  explicit UdpDevice(int port) : port_(port), socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (port < 1 || port > 65535 || socket_ < 0 ||
        ::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
      const std::string why = port < 1 || port > 65535 ? "no such port" : std::strerror(errno);
      if (socket_ >= 0)
        ::close(socket_);
      throw std::runtime_error(fmt::format("udp:{}: {}", port, why));
    }
  }
  ~UdpDevice() override { ::close(socket_); }
  UdpDevice(const UdpDevice&) = delete;
  UdpDevice& operator=(const UdpDevice&) = delete;

  DeviceState read() override {
    std::array<std::byte, 128> bytes{};
    for (int i = 0; i < most_a_tick; ++i) {
      sockaddr_in sender{};
      socklen_t length = sizeof(sender);
      const auto n =
          ::recvfrom(socket_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&sender), &length);
      if (n < 0)
        break;
      if (const auto packet = parse_hand_packet(std::span(bytes).first(n))) {
        state_.pose = packet->pose;
        state_.buttons = packet->buttons;
        number_ = packet->number;
        sender_ = sender;
        last_ = std::chrono::steady_clock::now();
        ++n_good_;
      } else {
        ++n_bad_;
      }
    }
    state_.is_there = n_good_ > 0 && std::chrono::steady_clock::now() - last_ < lost_after;
    is_there_ = state_.is_there;
    return state_;
  }

  void write(const deform::ProbeForce& force) override {
    if (!state_.is_there)
      return;
    std::array<std::byte, force_packet_size> bytes{};
    write_force_packet(number_, force, bytes);
    ::sendto(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
             reinterpret_cast<const sockaddr*>(&sender_), sizeof(sender_));
  }

  std::string status() const override {
    const std::int64_t good = n_good_, bad = n_bad_;
    std::string text = fmt::format("udp:{}: ", port_);
    text += is_there_  ? "connected"
            : good > 0 ? "lost: what it held stays where it is"
                       : "waiting for packets";
    if (bad > 0)
      text += fmt::format(", {} malformed", bad);
    return text;
  }

private:
  int port_, socket_;
  DeviceState state_;
  std::uint32_t number_ = 0;
  sockaddr_in sender_{};
  std::chrono::steady_clock::time_point last_{};
  std::atomic<std::int64_t> n_good_{0}, n_bad_{0};
  std::atomic<bool> is_there_{false};
};

} // namespace

std::unique_ptr<HandDevice> udp_device(int port) {
  return std::make_unique<UdpDevice>(port);
}

} // namespace maille::live
