#include "maille/live/device.hpp"

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>

#ifdef MAILLE_SPNAV
#include <spnav.h>

#include <atomic>
#include <poll.h>
#endif

namespace maille::live {

#ifdef MAILLE_SPNAV

namespace {

/// Value from the daemon at full deflection of the cap.
constexpr double full = 350;
constexpr double radians_a_second = 1.5;

class SpaceMouse : public HandDevice {
public:
  explicit SpaceMouse(double speed) : speed_(speed) {
    if (spnav_open() == -1)
      throw std::runtime_error("no SpaceMouse: its daemon does not run (package spacenavd), or the device is "
                               "not plugged in");
  }
  ~SpaceMouse() override { spnav_close(); }

  DeviceState read() override {
    pollfd daemon{spnav_fd(), POLLIN, 0};
    if (::poll(&daemon, 1, 0) > 0 && (daemon.revents & (POLLHUP | POLLERR | POLLNVAL)) != 0) {
      is_there_ = false;
      return state_ = {};
    }
    if (!is_there_)
      return state_;
    spnav_event event{};
    for (int i = 0; i < 16 && spnav_poll_event(&event) != 0; ++i) {
      if (event.type == SPNAV_EVENT_MOTION) {
        // Its axes: x right, y up, z towards the user.
        state_.velocity = speed_ / full * Eigen::Vector3d(event.motion.x, event.motion.y, event.motion.z);
        state_.turning =
            radians_a_second / full * Eigen::Vector3d(event.motion.rx, event.motion.ry, event.motion.rz);
      } else if (event.type == SPNAV_EVENT_BUTTON && event.button.bnum < 32) {
        const std::uint32_t bit = 1u << event.button.bnum;
        state_.buttons = event.button.press ? state_.buttons | bit : state_.buttons & ~bit;
      }
    }
    state_.is_there = true;
    return state_;
  }
  void write(const deform::ProbeForce&) override {}
  std::string status() const override { return is_there_ ? "SpaceMouse" : "SpaceMouse: lost"; }

private:
  double speed_;
  DeviceState state_;
  std::atomic<bool> is_there_{true};
};

} // namespace

std::unique_ptr<HandDevice> space_mouse(double metres_a_second) {
  return std::make_unique<SpaceMouse>(metres_a_second);
}

#else

std::unique_ptr<HandDevice> space_mouse(double) {
  throw std::runtime_error("this build knows no SpaceMouse: install libspnav-dev and build again");
}

#endif

} // namespace maille::live
