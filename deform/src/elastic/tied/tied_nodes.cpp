#include "elastic/tied/tied_nodes.hpp"

#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>

namespace maille::deform {

namespace {

/// Tied nodes and the numbers of their clusters.
std::map<std::int64_t, std::size_t> clusters_of(const std::vector<NodeTie>& ties) {
  std::map<std::int64_t, std::int64_t> first; // a node that stands for a cluster
  const auto root = [&](std::int64_t node) {
    while (first.at(node) != node)
      node = first.at(node);
    return node;
  };
  for (const NodeTie& tie : ties) {
    first.try_emplace(tie.one, tie.one);
    first.try_emplace(tie.other, tie.other);
    const std::int64_t one = root(tie.one), other = root(tie.other);
    first[std::max(one, other)] = std::min(one, other);
  }
  std::map<std::int64_t, std::size_t> number, of_node;
  for (const auto& entry : first)
    of_node[entry.first] = number.try_emplace(root(entry.first), number.size()).first->second;
  return of_node;
}

/// The directions along which a tie joins its nodes.
std::vector<Vec3> directions_of(const NodeTie& tie) {
  if (tie.normal != Vec3{})
    return {tie.normal};
  return {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
}

} // namespace

TiedNodes::TiedNodes(const NodeTies& ties, const FixedMask& fixed_components, const Displacement& diagonal) {
  const auto cluster_of = clusters_of(ties.ties);
  std::size_t n = 0;
  for (const auto& entry : cluster_of)
    n = std::max(n, entry.second + 1);
  std::vector<std::vector<std::int64_t>> nodes(n);
  for (const auto& [node, cluster] : cluster_of)
    nodes[cluster].push_back(node);
  std::vector<std::vector<const NodeTie*>> of_cluster(n);
  for (const NodeTie& tie : ties.ties)
    of_cluster[cluster_of.at(tie.one)].push_back(&tie);
  for (std::size_t c = 0; c < n; ++c) {
    const auto size = static_cast<Eigen::Index>(3 * nodes[c].size());
    std::vector<Eigen::VectorXd> rows;
    for (const NodeTie* tie : of_cluster[c])
      for (const Vec3& along : directions_of(*tie)) {
        Eigen::VectorXd row = Eigen::VectorXd::Zero(size);
        for (const auto& [node, sign] : {std::pair(tie->one, 1.0), std::pair(tie->other, -1.0)}) {
          const auto at = 3 * (std::ranges::lower_bound(nodes[c], node) - nodes[c].begin());
          for (int b = 0; b < 3; ++b)
            row[at + b] += sign * along[b];
        }
        rows.push_back(row);
      }
    Cluster cluster;
    std::vector<Eigen::Index> free, fixed;
    for (Eigen::Index i = 0; i < size; ++i) {
      const std::int64_t node = nodes[c][i / 3];
      const int b = static_cast<int>(i % 3);
      const bool is_held = fixed_components(b, node);
      (is_held ? fixed : free).push_back(i);
      (is_held ? cluster.fixed : cluster.free).push_back({node, b});
    }
    const auto m = static_cast<Eigen::Index>(rows.size());
    cluster.of_free.resize(m, static_cast<Eigen::Index>(free.size()));
    cluster.of_fixed.resize(m, static_cast<Eigen::Index>(fixed.size()));
    for (Eigen::Index r = 0; r < m; ++r) {
      for (std::size_t i = 0; i < free.size(); ++i)
        cluster.of_free(r, static_cast<Eigen::Index>(i)) = rows[r][free[i]];
      for (std::size_t i = 0; i < fixed.size(); ++i)
        cluster.of_fixed(r, static_cast<Eigen::Index>(i)) = rows[r][fixed[i]];
    }
    // D^-1 C^T (C D^-1 C^T)^+, of ties that say the same once, and nothing of those between fixed components.
    Eigen::VectorXd flexible(static_cast<Eigen::Index>(free.size()));
    for (std::size_t i = 0; i < free.size(); ++i)
      flexible[static_cast<Eigen::Index>(i)] = 1 / diagonal(cluster.free[i].component, cluster.free[i].node);
    const Eigen::MatrixXd back = flexible.asDiagonal() * cluster.of_free.transpose(),
                          gram = cluster.of_free * back;
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> inverse;
    inverse.setThreshold(1e-10);
    inverse.compute(gram);
    cluster.gain = back * inverse.pseudoInverse();
    clusters_.push_back(std::move(cluster));
  }
}

Eigen::VectorXd TiedNodes::gather(const Displacement& field, const std::vector<Component>& components) {
  Eigen::VectorXd values(static_cast<Eigen::Index>(components.size()));
  for (std::size_t i = 0; i < components.size(); ++i)
    values[static_cast<Eigen::Index>(i)] = field(components[i].component, components[i].node);
  return values;
}

void TiedNodes::bring_together(Displacement& u) const {
  for (const Cluster& cluster : clusters_) {
    const Eigen::VectorXd change = cluster.gain * (cluster.of_free * gather(u, cluster.free) +
                                                   cluster.of_fixed * gather(u, cluster.fixed));
    for (std::size_t i = 0; i < cluster.free.size(); ++i)
      u(cluster.free[i].component, cluster.free[i].node) -= change[static_cast<Eigen::Index>(i)];
  }
}

void TiedNodes::share(Displacement& f) const {
  for (const Cluster& cluster : clusters_) {
    const Eigen::VectorXd change =
        cluster.of_free.transpose() * (cluster.gain.transpose() * gather(f, cluster.free));
    for (std::size_t i = 0; i < cluster.free.size(); ++i)
      f(cluster.free[i].component, cluster.free[i].node) -= change[static_cast<Eigen::Index>(i)];
  }
}

void TiedNodes::take_out_tie_forces(Displacement& f) const {
  for (const Cluster& cluster : clusters_) {
    const Eigen::VectorXd of_ties = cluster.gain.transpose() * gather(f, cluster.free);
    const auto take = [&](const std::vector<Component>& components, const Eigen::MatrixXd& ties) {
      const Eigen::VectorXd change = ties.transpose() * of_ties;
      for (std::size_t i = 0; i < components.size(); ++i)
        f(components[i].component, components[i].node) -= change[static_cast<Eigen::Index>(i)];
    };
    take(cluster.free, cluster.of_free);
    take(cluster.fixed, cluster.of_fixed);
  }
}

List<NodalSpring> springs_at_ties(const Scene& scene, const Displacement& diagonal) {
  const Grid& grid = scene.specimen.grid;
  const int longest = std::max({grid.cells()[0], grid.cells()[1], scene.tied.planes});
  List<NodalSpring> springs = nodal_springs(scene);
  for (const NodeTie& tie : scene.tied.ties)
    for (const std::int64_t node : {tie.one, tie.other}) {
      NodalSpring spring{node, Eigen::Matrix3d::Zero()};
      for (const Vec3& along : directions_of(tie)) {
        const Eigen::Vector3d n(along[0], along[1], along[2]);
        double stiffness = 0;
        for (int b = 0; b < 3; ++b)
          stiffness += n[b] * n[b] * diagonal(b, node);
        spring.stiffness += stiffness / longest * n * n.transpose();
      }
      if (tie.spring > 0) { // across the normal the other node, as if it stood still
        const Eigen::Vector3d n(tie.normal[0], tie.normal[1], tie.normal[2]);
        spring.stiffness += tie.spring * (Eigen::Matrix3d::Identity() - n * n.transpose());
      }
      springs.push_back(spring);
    }
  std::ranges::stable_sort(springs, {}, &NodalSpring::node);
  List<NodalSpring> merged;
  for (const NodalSpring& spring : springs)
    if (!merged.empty() && merged.back().node == spring.node)
      merged.back().stiffness += spring.stiffness;
    else
      merged.push_back(spring);
  return merged;
}

OpenTie widest_tie(const NodeTies& tied, const Displacement& u) {
  OpenTie widest;
  for (const NodeTie& tie : tied.ties) {
    const Vec3 one = u.at(tie.one), other = u.at(tie.other);
    double along = 0, squared = 0;
    for (std::size_t b = 0; b < 3; ++b) {
      along += tie.normal[b] * (one[b] - other[b]);
      squared += (one[b] - other[b]) * (one[b] - other[b]);
    }
    const double gap = tie.normal == Vec3{} ? std::sqrt(squared) : std::abs(along);
    if (gap > widest.gap)
      widest = {gap, &tie};
  }
  return widest;
}

} // namespace maille::deform
