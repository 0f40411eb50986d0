#pragma once
/// What the parts of the module share: scenes and answers as Python holds them, arrays that are views, and
/// how a method that runs hears of Ctrl-C.

#include "maille/scene/answer.hpp"
#include "maille/scene/cell_fields.hpp"
#include "maille/scene/measure/measure.hpp"
#include "maille/scene/mechanics/mechanics.hpp"
#include "maille/scene/scene_builder.hpp"

#include <pybind11/functional.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace maille::python {

namespace py = pybind11;

struct SceneHandle {
  std::shared_ptr<const SceneAndMeasures> asked;
  const Scene& scene() const { return asked->scene; }
};

struct AnswerHandle {
  std::shared_ptr<const SceneAndMeasures> asked;
  Answer answer;
  std::optional<CellFields> fields{}; ///< once they were asked for, as the next
  std::optional<Mechanics> found{};
  const Scene& scene() const { return asked->scene; }
  bool has_displacement() const { return !answer.displacement.empty(); }
};

/// Control of a method that runs without the interpreter's lock: the thread that called is asked 20 times a
/// second whether Ctrl-C was pressed, and passes progress on as often.
class Steering {
public:
  /// @param progress a function of the fraction done and of what is being done, or None
  Steering(int threads, std::optional<double> seconds, std::optional<std::int64_t> bytes,
           py::object progress);
  const Control& control() const { return control_; }
  /// @throws what Ctrl-C or `progress` has raised; to be called with the lock
  void finish();

private:
  bool should_stop();
  void tell(double fraction, std::string_view what);
  /// Runs with the lock; what it raises stops the method.
  template<class Ask>
  void with_lock(Ask&& ask);

  Control control_;
  py::object progress_;
  std::atomic<bool> stopped_ = false;
  std::exception_ptr raised_;
  std::thread::id caller_ = std::this_thread::get_id();
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now(), last_told_{};
};

/// Skips destructors of static objects at the end of the interpreter, while work that Ctrl-C interrupted
/// still uses them. @param is_at_work true now, and asked again at the end
void skip_destructors_while(bool (*is_at_work)());

/// Runs `work` in a thread of its own. Ctrl-C raises KeyboardInterrupt at once; the work goes on unseen.
/// @pre the caller holds the interpreter's lock @param kept objects that the work reads
void run_in_thread(std::function<void()> work, py::object kept = {});

/// Runs `make` in a thread of its own, as above. @return its result
template<class Make>
auto made_in_thread(Make make, py::object kept = {}) {
  const auto made = std::make_shared<std::optional<decltype(make())>>();
  run_in_thread([made, make = std::move(make)] { made->emplace(make()); }, std::move(kept));
  return std::move(**made);
}

/// Guards an object whose methods release the interpreter's lock: a second thread is refused while it lives.
class SoleUse {
public:
  /// @throws std::runtime_error, RuntimeError in Python
  SoleUse(std::atomic<bool>& is_used, const char* what) : is_used_(is_used) {
    if (is_used.exchange(true))
      throw std::runtime_error(std::string("this ") + what +
                               " is in use by another thread: expected one thread at a time");
  }
  ~SoleUse() { is_used_ = false; }
  SoleUse(const SoleUse&) = delete;
  SoleUse& operator=(const SoleUse&) = delete;

private:
  std::atomic<bool>& is_used_;
};

/// @throws ValueError for NaN and infinity
void require_finite(const char* what, double value);
void require_finite(const char* what, const Vec3& values);

/// A read-only array over memory that `owner` keeps.
template<class T>
py::array view_of(py::handle owner, const T* data, std::vector<py::ssize_t> shape,
                  std::vector<py::ssize_t> strides) {
  py::array_t<T> array(std::move(shape), std::move(strides), data, owner);
  py::detail::array_proxy(array.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return array;
}

/// Sizes of a grid with the slowest axis first, as many as it has dimensions.
std::vector<py::ssize_t> shape_of(const Grid& grid, const Index3& size);

/// A displacement as (..., components), x fastest and components slowest in memory.
py::array displacement_view(py::handle owner, const Grid& grid, const Displacement& displacement);

/// The parts of the module.
void bind_fits(py::module_& module);
void bind_scenes(py::module_& module);
void bind_answers(py::module_& module);
void bind_warps(py::module_& module);
void bind_worlds(py::module_& module);

} // namespace maille::python
