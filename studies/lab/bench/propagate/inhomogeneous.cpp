#include "bench/subjects.hpp"

#include "feasible/wavefront/wavefront.hpp"
#include "rivals/rivals.hpp"
#include "support/bodies/named_bodies.hpp"

#include <algorithm>
#include <cmath>

namespace maille::lab {

namespace {

/// One named body with everything that is prepared before the clock starts.
struct Opponents {
  explicit Opponents(const std::string& name, int n)
      : scene(named_body(name, n)), limits(scene), tiles(scene, limits) {
    tiles.move(scene.prescribed); // settles the quantum and caches the links of every tile
    for (int component = 0; component < scene.dimension(); ++component) {
      quantum.push_back(tiles.quantum(component));
      links.emplace_back(scene, limits, component, quantum.back());
    }
    largest_quantum = *std::max_element(quantum.begin(), quantum.end());
  }

  /// The request of a component in quanta.
  FlatSeed seed(std::size_t component) const {
    const Prescribed& p = scene.prescribed[component];
    return {p.node, static_cast<std::int32_t>(std::llround(p.value / quantum[component]))};
  }
  void rest() {
    state.assign(links.size(),
                 std::vector<std::int32_t>(static_cast<std::size_t>(scene.specimen.grid.n_nodes()), 0));
  }

  /// Each component by Dijkstra: up with the one table, down with the other and signs turned.
  void by_dijkstra() {
    for (std::size_t b = 0; b < links.size(); ++b) {
      const FlatSeed wanted = seed(b);
      if (wanted.value >= 0) {
        dijkstra_flat(links[b].drop, links[b].stride, state[b], std::span(&wanted, 1));
        continue;
      }
      const FlatSeed mirrored{wanted.node, -wanted.value};
      for (std::int32_t& x : state[b])
        x = -x;
      dijkstra_flat(links[b].climb, links[b].stride, state[b], std::span(&mirrored, 1));
      for (std::int32_t& x : state[b])
        x = -x;
    }
  }

  Scene scene;
  LinkLimits limits;
  deform::TiledBody tiles;
  std::vector<double> quantum;
  double largest_quantum = 0;
  std::vector<FlatLinks> links;
  std::vector<std::vector<std::int32_t>> state; ///< of Dijkstra and enhanced chain mail, [component][node]
};

} // namespace

double bench_inhomogeneous(const BenchOptions& options, BenchReport& report) {
  const int n = options.quick ? 16 : 64, repeats = options.quick ? 1 : 7;
  double worst_violation = 0;
  for (const std::string_view name : named_bodies()) {
    Opponents body(std::string(name), n);
    const double tiled = median_seconds(
        repeats, [&] { body.tiles.rest(); }, [&] { body.tiles.move(body.scene.prescribed); });
    Displacement displacement(body.scene.specimen.grid);
    body.tiles.copy_to(displacement);
    const double violation = largest_violation(body.scene, body.limits, displacement);
    const double dijkstra = median_seconds(
        repeats, [&] { body.rest(); }, [&] { body.by_dijkstra(); });
    std::vector<std::int32_t> target;
    for (std::size_t b = 0; b < body.links.size(); ++b)
      target.push_back(body.seed(b).value);
    ChainMailOutcome rival;
    const double chain_mail = median_seconds(
        std::min(repeats, 3), [&] { body.rest(); },
        [&] {
          rival = enhanced_chain_mail(body.links, body.largest_quantum, body.state,
                                      body.scene.prescribed[0].node, target);
        });

    // In units in the last place of float32 of the largest displacement.
    const double ulp = std::ldexp(1.0, std::ilogb(body.scene.largest_prescribed()) - 23);
    worst_violation = std::max(worst_violation, violation * body.scene.specimen.grid.spacing()[0] / ulp);
    const double coordinates = 3e-6 * static_cast<double>(body.scene.specimen.n_matter_nodes());
    report.add({{"body", std::string(name)},
                {"nodes", std::to_string(n) + "^3"},
                {"limits_ms", 1e3 * tiled},
                {"limits_mcoord_s", coordinates / tiled},
                {"dijkstra_ms", 1e3 * dijkstra},
                {"dijkstra_over_limits", dijkstra / tiled},
                {"enhanced_chain_mail_ms", 1e3 * chain_mail},
                {"violation_limits", violation},
                {"enhanced_violated_links_percent",
                 100.0 * static_cast<double>(rival.violated_links) / static_cast<double>(rival.links)},
                {"enhanced_violation", rival.largest_violation / body.scene.specimen.grid.spacing()[0]}});
    report.checks.push_back({"dijkstra_over_limits_" + std::string(name), dijkstra / tiled});
  }
  return worst_violation;
}

} // namespace maille::lab
