#include "bench/materials/materials.hpp"

#include "maille/scene/answer.hpp"
#include "maille/scene/read_scene.hpp"

#include <Eigen/Core>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

namespace maille::lab {

namespace {

constexpr std::array<const char*, 2> tissues{"muscle/vastus_lateralis", "muscle/strongly_anisotropic"};
constexpr std::array<double, 5> angles{0, 10, 20, 30, 45};
constexpr std::array<const char*, 3> methods{"limits", "relaxed", "coupled"};

/// A strip clamped at one end and pulled at the other. @param lattice "grid" or "fibre"
Scene strip(const char* tissue, double degrees, const char* lattice, int across) {
  return parse_scene(
      fmt::format(
          "units = \"m, rad\"\n[specimen]\nshape = \"box\"\nlattice = \"{0}\"\ncells = [{1}, {2}, "
          "{2}]\nspacing = {3}\n"
          "material = \"{4}\"\nfibre = {{ angle = \"{5} deg\", plane = \"xz\" }}\n[[hold]]\nwhere = \"x-\"\n"
          "[[move]]\nwhere = \"x+\"\nby = [\"1 mm\", 0, 0]\n[limits]\nfrom = \"taut\"\n",
          lattice, 2 * across, across, 0.016 / across, tissue, degrees),
      fmt::format("{} at {} deg.toml", tissue, degrees));
}

Eigen::Matrix3d turn_of(const Placement& placement) {
  Eigen::Matrix3d turn;
  for (Eigen::Index r = 0; r < 3; ++r)
    for (Eigen::Index c = 0; c < 3; ++c)
      turn(r, c) = placement.direction[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
  return turn;
}

/// A displacement on a box's grid between its nodes, linear in each coordinate; nothing outside.
std::optional<Eigen::Vector3d> between_nodes(const Specimen& box, const Displacement& u,
                                             const Eigen::Vector3d& x) {
  const Grid& grid = box.grid;
  Index3 cell{};
  Eigen::Vector3d part;
  for (std::size_t a = 0; a < 3; ++a) {
    const auto i = static_cast<Eigen::Index>(a);
    const double place = (x[i] - box.origin[a]) / grid.spacing()[a];
    if (place < 0 || place > grid.cells()[a])
      return std::nullopt;
    cell[a] = std::min(static_cast<int>(place), grid.cells()[a] - 1);
    part[i] = place - cell[a];
  }
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1;
    for (int a = 0; a < 3; ++a)
      weight *= corner >> a & 1 ? part[a] : 1 - part[a];
    for (int b = 0; b < 3; ++b)
      value[b] += weight * u(b, grid.corner(cell, corner));
  }
  return value;
}

/// Relative L2 error of an answer on a turned lattice against one on the box's own, at its free nodes within
/// the box.
double error_on_turned(const Scene& turned, const Displacement& u, const Scene& box,
                       const Displacement& truth) {
  const Specimen& body = turned.specimen;
  const Eigen::Matrix3d turn = turn_of(body.placement);
  std::vector<bool> is_prescribed(static_cast<std::size_t>(body.grid.n_nodes()), false);
  for (const Prescribed& p : turned.prescribed)
    is_prescribed[static_cast<std::size_t>(p.node)] = true;
  double difference = 0, length = 0;
  for (std::int64_t node = 0; node < body.grid.n_nodes(); ++node) {
    const Index3 at = body.grid.node_at(node);
    if (is_prescribed[static_cast<std::size_t>(node)] || !body.is_node(at))
      continue;
    const Vec3 rest = body.position(at);
    const auto r = between_nodes(box.specimen, truth, turn * Eigen::Vector3d(rest[0], rest[1], rest[2]));
    if (!r)
      continue;
    const Eigen::Vector3d w(u(0, node), u(1, node), u(2, node));
    difference += (turn * w - *r).squaredNorm();
    length += r->squaredNorm();
  }
  return std::sqrt(difference / length);
}

} // namespace

void bench_turned_fibres(MaterialsBench& bench, double start, double end) {
  const int across = bench.is_quick() ? 4 : 16;
  double done = 0;
  for (const char* tissue : tissues)
    for (const double degrees : angles) {
      bench.at(start + (end - start) * done++ / static_cast<double>(tissues.size() * angles.size()),
               fmt::format("{}, fibres at {} deg", tissue, degrees));
      const Scene box = strip(tissue, degrees, "grid", across),
                  turned = strip(tissue, degrees, "fibre", across);
      const Displacement truth = bench.displacement(box, "fem_q2");
      nlohmann::ordered_json row{
          {"fibres_turned", tissue}, {"fibre_deg", degrees}, {"reference", "fem_q2 on the grid"}};
      for (const char* method : methods)
        row[fmt::format("{}_on_grid", method)] =
            compare(box, bench.displacement(box, method), truth).relative_l2;
      for (const char* method : methods)
        row[fmt::format("{}_on_fibre_lattice", method)] =
            error_on_turned(turned, bench.displacement(turned, method), box, truth);
      bench.report().rows.push_back(std::move(row));
    }
}

} // namespace maille::lab
