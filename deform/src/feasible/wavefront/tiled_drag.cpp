#include "feasible/bounds/drag_engine.hpp"
#include "feasible/wavefront/wavefront.hpp"

#include <algorithm>
#include <cmath>

namespace maille::deform {

namespace {

class TiledDrag : public DragEngine {
public:
  TiledDrag(const Scene& scene, const LinkLimits& limits, int threads, const Displacement* state)
      : scene_(scene), threads_(threads), body_(scene, limits) {
    if (state)
      body_.set_state(*state);
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
    body_.move_in_place(asked_, threads_);
    for (DragHandle& handle : handles)
      if (handle.is_moving)
        handle.target = {};
    auto place = asked_.begin() + static_cast<std::ptrdiff_t>(n_holds_);
    for (DragHandle& handle : handles)
      for (int b = 0; b < scene_.dimension(); ++b)
        if (!is_held(b, handle.node)) {
          if (handle.is_moving)
            handle.target[b] = place->value;
          ++place;
        }
    return body_.n_visits() - visits;
  }

  double displacement(int component, std::int64_t node) const override {
    const auto exact = std::ranges::find_if(
        handles_asked(), [&](const Prescribed& p) { return p.component == component && p.node == node; });
    return exact != handles_asked().end() ? exact->value : body_.displacement(component, node);
  }
  void copy_to(Displacement& state) const override { body_.copy_to(state); }
  Drag::Residue residue() const override {
    Drag::Residue residue;
    const auto take = [&](double u, std::int64_t node, int component) {
      if (std::abs(u) > residue.largest)
        residue = {std::abs(u), node, component};
    };
    for (int b = 0; b < scene_.dimension(); ++b)
      for (std::int64_t node = 0; node < scene_.specimen.grid.n_nodes(); ++node)
        take(body_.displacement(b, node), node, b);
    // Handles are where they were put, not at the next whole quantum.
    residue.largest = std::abs(displacement(residue.component, residue.node));
    for (const Prescribed& p : handles_asked())
      take(p.value, p.node, p.component);
    return residue;
  }
  const std::string& algorithm() const override { return algorithm_; }

private:
  /// What the last move put the handles to.
  std::span<const Prescribed> handles_asked() const {
    return std::span(asked_).subspan(std::min(n_holds_, asked_.size()));
  }
  bool is_held(int component, std::int64_t node) const {
    return std::ranges::any_of(scene_.prescribed, [&](const Prescribed& p) {
      return p.held && p.component == component && p.node == node;
    });
  }

  const Scene& scene_;
  int threads_;
  TiledBody body_;
  std::size_t n_holds_ = 0;
  std::vector<Prescribed> asked_;
  std::string algorithm_ = "tiled wavefront";
};

} // namespace

std::unique_ptr<DragEngine> make_tiled_drag(const Scene& scene, const LinkLimits& limits, int threads,
                                            const Displacement* state) {
  return std::make_unique<TiledDrag>(scene, limits, threads, state);
}

} // namespace maille::deform
