/// Devices as they are plugged in: a daemon of a SpaceMouse, a game controller of SDL, a program that sends
/// packets. Each is lost in mid-drag.

#include "live/by_hand.hpp"
#include "support/kit.hpp"

#ifdef MAILLE_HAS_SDL
#include <SDL.h>
#endif

#include <arpa/inet.h>
#include <atomic>
#include <chrono>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <thread>
#include <unistd.h>

namespace maille::live {
namespace {
using test::mm;
using test::write_hand_packet;

void wait_for(const std::function<bool()>& is_there) {
  for (int i = 0; i < 2000 && !is_there(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
}

/// Speaks as spacenavd does: eight integers an event, the first its kind.
class SpaceDaemon {
public:
  explicit SpaceDaemon(const std::string& path) : listening_(::socket(AF_UNIX, SOCK_STREAM, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof(address.sun_path) - 1);
    EXPECT_EQ(::bind(listening_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
    EXPECT_EQ(::listen(listening_, 1), 0);
  }
  ~SpaceDaemon() {
    close();
    ::close(listening_);
  }
  void send(const std::array<std::int32_t, 8>& event) {
    if (client_ < 0)
      client_ = ::accept(listening_, nullptr, nullptr);
    EXPECT_EQ(::send(client_, event.data(), sizeof(event), MSG_NOSIGNAL),
              static_cast<ssize_t>(sizeof(event)));
  }
  void push(int x, int y, int z) { send({0, x, y, -z, 0, 0, 0, 8}); } // the daemon's z points away
  void press(bool is_down) { send({is_down ? 1 : 2, 0, 0, 0, 0, 0, 0, 0}); }
  void close() {
    if (client_ >= 0)
      ::close(std::exchange(client_, -1));
  }

private:
  int listening_, client_ = -1;
};

TEST(LiveAttachedContract, ASpaceMouseMovesTheProbeAndIsLostInMidDrag) {
  const maille::test::TemporaryFolder folder;
  const std::string path = folder.path() / "spnav.sock";
  SpaceDaemon daemon(path);
  ::setenv("SPNAV_SOCKET", path.c_str(), 1);
  std::shared_ptr<HandDevice> device;
  try {
    device = space_mouse(0.05);
  } catch (const std::runtime_error& error) {
    GTEST_SKIP() << error.what();
  }
  daemon.press(true);
  wait_for([&] { return (device->read().buttons & 1) != 0; });
  EXPECT_EQ(device->read().buttons, 1u);
  daemon.push(350, 0, 0);
  wait_for([&] { return device->read().velocity[0] > 0; });
  EXPECT_NEAR(device->read().velocity[0], 0.05, 1e-12); // pushed as far as it goes
  const WorldScene scene = read_world_scene(test::world_folder / "bolt.toml");
  Session session(scene, {});
  session.use(device);
  session.grip({2, {}}, 1);
  const Eigen::Vector3d begin = session.state()->frames[2].position;
  wait_for([&] { return session.state()->frames[2].position[0] > begin[0] + 1 * mm; });
  EXPECT_GT(session.state()->frames[2].position[0], begin[0] + 1 * mm);
  daemon.close();
  wait_for([&] { return !session.has_device(); });
  EXPECT_FALSE(session.has_device());
  EXPECT_EQ(device->status(), "SpaceMouse: lost");
  ASSERT_TRUE(session.wait_idle(30));
  const Eigen::Vector3d left = session.state()->frames[2].position;
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  EXPECT_EQ(session.state()->frames[2].position, left);
  session.let_go(true, 2);
  EXPECT_EQ(session.n_penetrations(), 0);
}

/// A window with a scripted user.
class Accompanied : public Window {
public:
  Accompanied(Window& window, std::function<void(Window&)> each_poll)
      : window_(window), each_poll_(std::move(each_poll)) {}
  std::vector<Event> poll(double seconds) override {
    each_poll_(window_);
    std::vector<Event> events = window_.poll(std::min(seconds, 0.005));
    if (is_closed_) {
      events.emplace_back();
      events.back().kind = EventKind::close;
    }
    return events;
  }
  void close() { is_closed_ = true; }
  void show(const Shown& shown) override {
    shown_ = shown;
    window_.show(shown);
  }
  bool says(const std::string& text) const {
    return std::ranges::any_of(
        shown_.panel, [&](const Widget& widget) { return widget.label.find(text) != std::string::npos; });
  }
  void wake() override { window_.wake(); }
  int width() const override { return window_.width(); }
  int height() const override { return window_.height(); }
  int panel_width() const override { return window_.panel_width(); }
  std::string driver() const override { return window_.driver(); }
  void set_full_screen(bool is_full) override { window_.set_full_screen(is_full); }
  std::vector<std::uint8_t> screenshot() override { return window_.screenshot(); }

private:
  Window& window_;
  std::function<void(Window&)> each_poll_;
  Shown shown_;
  bool is_closed_ = false;
};

LiveReport played_with(Window& window, std::shared_ptr<HandDevice> device) {
  LiveSettings settings;
  settings.scene = test::world_folder / "maze.toml";
  settings.device = std::move(device);
  const LiveTools tools = test::tools();
  return run_live(window, settings, tools);
}

/// Calls steps one after another, each after a number of milliseconds since the one before.
class Steps {
public:
  explicit Steps(std::vector<std::pair<int, std::function<void()>>> steps) : steps_(std::move(steps)) {}
  void operator()() {
    const auto now = std::chrono::steady_clock::now();
    if (next_ == 0 && last_ == std::chrono::steady_clock::time_point{})
      last_ = now;
    if (next_ < steps_.size() && now - last_ >= std::chrono::milliseconds(steps_[next_].first)) {
      steps_[next_++].second();
      last_ = now;
    }
  }

private:
  std::vector<std::pair<int, std::function<void()>>> steps_;
  std::size_t next_ = 0;
  std::chrono::steady_clock::time_point last_{};
};

#ifdef MAILLE_HAS_SDL
// The piece of the maze is pushed upwards by a game controller that SDL has: the whole way of its events.
TEST(LiveAttachedContract, AGameControllerMovesThePieceAndIsPulledOutInMidDrag) {
  if (!has_windows())
    GTEST_SKIP() << "no windows in this build";
  SDL_setenv("SDL_VIDEODRIVER", "dummy", 1);
  WindowSettings asked;
  asked.width = 640;
  asked.height = 480;
  asked.game_controllers = true;
  const std::unique_ptr<Window> sdl = open_window(asked);
  SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1"); // nothing has the focus here
  int number = -1;
  SDL_Joystick* joystick = nullptr;
  const auto device = std::make_shared<GamePad>(0.05);
  Accompanied* beside = nullptr;
  bool was_there = false, said_lost = false;
  Steps steps({{300,
                [&] {
                  number = SDL_JoystickAttachVirtual(SDL_JOYSTICK_TYPE_GAMECONTROLLER,
                                                     SDL_CONTROLLER_AXIS_MAX, SDL_CONTROLLER_BUTTON_MAX, 0);
                  ASSERT_GE(number, 0) << SDL_GetError();
                  joystick = SDL_JoystickOpen(number);
                }},
               {100, [&] { SDL_JoystickSetVirtualButton(joystick, SDL_CONTROLLER_BUTTON_A, 1); }},
               {50, [&] { SDL_JoystickSetVirtualAxis(joystick, SDL_CONTROLLER_AXIS_LEFTY, -32768); }},
               {300,
                [&] {
                  was_there = beside->says("game controller");
                  SDL_JoystickDetachVirtual(number);
                }},
               {200, [&] {
                  said_lost = beside->says("game controller: lost");
                  beside->close();
                }}});
  Accompanied window(*sdl, [&](Window&) { steps(); });
  beside = &window;
  const LiveReport report = played_with(window, device);
  if (joystick != nullptr)
    SDL_JoystickClose(joystick);
  EXPECT_TRUE(was_there);
  EXPECT_TRUE(said_lost) << device->status();
  EXPECT_GT(report.last_state->frames[1].position[1], 2 * mm + 5 * mm); // it began at 2 mm
  EXPECT_EQ(report.penetrations, 0);
  EXPECT_TRUE(test::has(report.trajectory, "piece"));
}
#endif

TEST(LiveAttachedContract, AProgramThatSendsPacketsMovesThePieceAndEndsInMidDrag) {
  constexpr int port = 47914;
  std::atomic<bool> is_over{false};
  std::thread program([&] {
    const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    HandPacket packet;
    for (int i = 0; i < 700; ++i) { // at 1 kHz: waits, takes hold, moves up by 20 mm
      packet.number = static_cast<std::uint32_t>(i);
      packet.buttons = i > 300 ? 1 : 0;
      packet.pose.position = {0, i > 400 ? (i - 400) * 20.0 / 300 * mm : 0, 0};
      std::array<std::byte, hand_packet_size> bytes{};
      write_hand_packet(packet, bytes);
      if (i % 50 == 7)
        bytes[0] = std::byte{0};
      (void)::sendto(socket, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to),
                     sizeof(to));
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    ::close(socket);
    is_over = true;
  });
  HeadlessWindow none(320, 240);
  Accompanied* beside = nullptr;
  bool said_lost = false, said_malformed = false;
  Accompanied window(none, [&](Window&) {
    said_malformed = said_malformed || beside->says("malformed");
    said_lost = said_lost || beside->says("lost");
    if (is_over && said_lost)
      beside->close();
  });
  beside = &window;
  const LiveReport report = played_with(window, udp_device(port));
  program.join();
  EXPECT_TRUE(said_malformed);
  EXPECT_NEAR(report.last_state->frames[1].position[1], 22 * mm, 1.5 * mm);
  EXPECT_EQ(report.penetrations, 0);
}

} // namespace
} // namespace maille::live
