// How a method that runs hears of Ctrl-C, and arrays over memory of the module.

#include "binding.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <future>
#include <utility>

namespace maille::python {

namespace {

constexpr std::chrono::milliseconds between_looks{50};

/// Work whose caller was interrupted, and the objects that it reads.
auto& work_left_behind() {
  static auto* const all = new std::vector<std::pair<py::object, std::future<void>>>;
  return *all;
}

bool is_done(const std::future<void>& work, std::chrono::milliseconds within) {
  return work.wait_for(within) == std::future_status::ready;
}

bool is_any_at_work() {
  return !std::ranges::all_of(work_left_behind(), [](const auto& one) { return is_done(one.second, {}); });
}

} // namespace

Steering::Steering(int threads, std::optional<double> seconds, std::optional<std::int64_t> bytes,
                   py::object progress)
    : progress_(std::move(progress)) {
  if (threads < 1)
    throw py::value_error("threads: expected 1 or more, found " + std::to_string(threads));
  if (seconds && !(*seconds >= 0))
    throw py::value_error("seconds: expected 0 or more, found " + std::to_string(*seconds));
  if (bytes && *bytes < 0)
    throw py::value_error("bytes: expected 0 or more, found " + std::to_string(*bytes));
  control_.threads = threads;
  control_.seconds_budget = seconds;
  control_.bytes_budget = bytes;
  control_.stop_requested = [this] { return should_stop(); };
  if (!progress_.is_none())
    control_.progress = [this](double fraction, std::string_view what) { tell(fraction, what); };
}

void skip_destructors_while(bool (*is_at_work)()) {
  static bool (*const asked)() = is_at_work; // a module has one kind of work
  [[maybe_unused]] static const int once = on_exit(
      [](int exit_code, void*) {
        if (!asked())
          return;
        std::fflush(nullptr);
        std::_Exit(exit_code);
      },
      nullptr);
}

void run_in_thread(std::function<void()> work, py::object kept) {
  auto& behind = work_left_behind();
  std::erase_if(behind, [](const auto& one) { return is_done(one.second, {}); });
  std::future<void> running = std::async(std::launch::async, std::move(work));
  const auto waited = [&] {
    const py::gil_scoped_release unlocked;
    return is_done(running, between_looks);
  };
  while (!waited())
    if (PyErr_CheckSignals() != 0) {
      skip_destructors_while(is_any_at_work);
      behind.emplace_back(std::move(kept), std::move(running));
      throw py::error_already_set();
    }
  running.get();
}

void require_finite(const char* what, double value) {
  if (!std::isfinite(value))
    throw py::value_error(std::string(what) + ": expected finite numbers, found " + std::to_string(value));
}

void require_finite(const char* what, const Vec3& values) {
  for (const double value : values)
    require_finite(what, value);
}

template<class Ask>
void Steering::with_lock(Ask&& ask) {
  const py::gil_scoped_acquire lock;
  try {
    ask();
  } catch (...) {
    raised_ = std::current_exception();
    stopped_ = true;
  }
}

bool Steering::should_stop() {
  if (stopped_ || std::this_thread::get_id() != caller_)
    return stopped_;
  if (const auto now = std::chrono::steady_clock::now(); now - last_ > between_looks) {
    last_ = now;
    with_lock([] {
      if (PyErr_CheckSignals() != 0)
        throw py::error_already_set();
    });
  }
  return stopped_;
}

void Steering::tell(double fraction, std::string_view what) {
  const auto now = std::chrono::steady_clock::now();
  if (stopped_ || std::this_thread::get_id() != caller_ || now - last_told_ < between_looks)
    return;
  last_told_ = now;
  with_lock([&] { progress_(fraction, std::string(what)); });
}

void Steering::finish() {
  if (raised_)
    std::rethrow_exception(std::exchange(raised_, nullptr));
}

std::vector<py::ssize_t> shape_of(const Grid& grid, const Index3& size) {
  std::vector<py::ssize_t> shape;
  for (int axis = grid.dimension(); axis-- > 0;)
    shape.push_back(size[axis]);
  return shape;
}

py::array displacement_view(py::handle owner, const Grid& grid, const Displacement& displacement) {
  constexpr py::ssize_t number = sizeof(double);
  std::vector<py::ssize_t> shape = shape_of(grid, grid.nodes()), strides;
  for (int axis = grid.dimension(); axis-- > 0;)
    strides.push_back(number * grid.stride(axis));
  shape.push_back(static_cast<py::ssize_t>(displacement.n_components()));
  strides.push_back(number * grid.n_nodes());
  return view_of(owner, displacement.values().data(), std::move(shape), std::move(strides));
}

} // namespace maille::python
