#include "maille/deform/propagate/wavefront.hpp"
#include "propagate/drag_engine.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

class TiledDrag : public DragEngine {
public:
  TiledDrag(const Scene& scene, const LinkLimits& limits, int threads, const Displacement& state)
      : scene_(scene), threads_(threads), body_(scene, limits), state_(state) {
    body_.set_state(state);
    body_.copy_to(state_);
    for (const Prescribed& p : scene.prescribed)
      n_holds_ += p.held ? 1 : 0;
  }

  bool take(DragHandle&) override { return true; }

  std::int64_t move(std::span<DragHandle> handles) override {
    asked_.clear();
    asked_.reserve(n_holds_ + 3 * handles.size());
    for (const Prescribed& p : scene_.prescribed)
      if (p.held)
        asked_.push_back(p);
    for (const DragHandle& handle : handles)
      for (int b = 0; b < scene_.dimension(); ++b)
        if (!is_held(b, handle.node)) {
          const auto i = static_cast<std::size_t>(b);
          asked_.push_back(
              {handle.node, b, handle.is_moving ? handle.target[i] : handle.value[i], !handle.is_moving});
        }
    const std::int64_t visits = body_.n_visits();
    const std::vector<Prescribed> admitted = body_.move(asked_, threads_);
    for (DragHandle& handle : handles)
      if (handle.is_moving)
        handle.target = {};
    auto place = admitted.begin() + static_cast<std::ptrdiff_t>(n_holds_);
    for (DragHandle& handle : handles)
      for (int b = 0; b < scene_.dimension(); ++b)
        if (!is_held(b, handle.node)) {
          if (handle.is_moving)
            handle.target[static_cast<std::size_t>(b)] = place->value;
          ++place;
        }
    body_.copy_changes_to(state_);
    return body_.n_visits() - visits;
  }

  double displacement(int component, std::int64_t node) const override { return state_(component, node); }
  void copy_to(Displacement& state) const override { state = state_; }
  Drag::Residue residue() const override {
    Drag::Residue residue;
    for (int b = 0; b < scene_.dimension(); ++b)
      for (std::int64_t node = 0; node < scene_.specimen.grid.n_nodes(); ++node)
        if (const double u = std::abs(state_(b, node)); u > residue.largest)
          residue = {u, node, b};
    return residue;
  }
  const std::string& algorithm() const override { return algorithm_; }
  std::int64_t bytes() const override {
    std::size_t numbers = 0;
    for (const auto& component : state_.component)
      numbers += component.capacity();
    return static_cast<std::int64_t>(sizeof(*this) + numbers * sizeof(double) +
                                     asked_.capacity() * sizeof(Prescribed)) +
           body_.bytes();
  }

private:
  bool is_held(int component, std::int64_t node) const {
    return std::ranges::any_of(scene_.prescribed, [&](const Prescribed& p) {
      return p.held && p.component == component && p.node == node;
    });
  }

  const Scene& scene_;
  int threads_;
  TiledBody body_;
  Displacement state_;
  std::size_t n_holds_ = 0;
  std::vector<Prescribed> asked_;
  std::string algorithm_ = "tiled wavefront";
};

} // namespace

std::unique_ptr<DragEngine> make_tiled_drag(const Scene& scene, const LinkLimits& limits, int threads,
                                            const Displacement& state) {
  return std::make_unique<TiledDrag>(scene, limits, threads, state);
}

} // namespace maille::deform
