#include "elastic/model/lattice_elasticity.hpp"

#include "elastic/model/thin_cells.hpp"

#include <Eigen/LU>

#include <bit>
#include <limits>
#include <optional>
#include <unordered_map>

namespace maille::deform {

namespace {

/// Place of a strain in the scene's order: normal strains first, then xy, or 23 13 12.
template<int dimension>
constexpr int shear_row(int a, int b) {
  return dimension == 2 ? 2 : 6 - a - b; // yz: 3, xz: 4, xy: 5 of 0 1 2
}

/// The lower corners of the edges along every axis.
template<int dimension>
struct Tails {
  int corner[dimension][1 << (dimension - 1)] = {};
  constexpr const int* operator[](int a) const { return corner[a]; }
};
template<int dimension>
constexpr Tails<dimension> edge_tails() {
  Tails<dimension> tails;
  for (int a = 0; a < dimension; ++a) {
    int n = 0;
    for (int corner = 0; corner < 1 << dimension; ++corner)
      if (!(corner & 1 << a))
        tails.corner[a][n++] = corner;
  }
  return tails;
}

using Matter = std::array<float, 5>; ///< material, thin axes and fibre
struct HashOfMatter {
  std::size_t operator()(const Matter& matter) const {
    std::uint64_t hash = 0;
    for (const float number : matter)
      hash = (hash ^ std::bit_cast<std::uint32_t>(number + 0.0F)) * 0x9e3779b97f4a7c15U;
    return static_cast<std::size_t>(hash ^ hash >> 32);
  }
};

/// Shortest run of cells of one kind along x that vector loops pay off on.
constexpr std::int64_t fewest_cells_of_run = 3;

} // namespace

LatticeElasticity::LatticeElasticity(const Scene& scene)
    : scene_(scene), grid_(scene.specimen.grid), end_cell_(grid_.n_cells()), springs_(nodal_springs(scene)) {
  ThreadTeam alone(1);
  find_kinds(alone);
}

LatticeElasticity::LatticeElasticity(const Scene& scene, ThreadTeam& team)
    : scene_(scene), grid_(scene.specimen.grid), end_cell_(grid_.n_cells()), springs_(nodal_springs(scene)) {
  find_kinds(team);
}

LatticeElasticity::LatticeElasticity(const Scene& scene, ThreadTeam& team, LayerRange layers)
    : scene_(scene), grid_(scene.specimen.grid), first_cell_(grid_.cell({0, 0, layers.first})),
      end_cell_(grid_.cell({0, 0, layers.end})), first_node_(grid_.node({0, 0, layers.first})),
      springs_(nodal_springs(scene)) {
  find_kinds(team);
}

LatticeElasticity::LatticeElasticity(const Scene& scene, ThreadTeam& team,
                                     const std::function<Matrix6(std::int64_t)>& stiffness)
    : scene_(scene), grid_(scene.specimen.grid), end_cell_(grid_.n_cells()), springs_(nodal_springs(scene)) {
  kinds_.resize(scene.specimen.n_matter_cells());
  kind_of_.assign(grid_.n_cells(), -1);
  std::int32_t next = 0;
  for (std::int64_t cell = 0; cell < grid_.n_cells(); ++cell)
    if (scene.specimen.is_matter(cell))
      kind_of_[cell] = next++;
  for_parts(kind_of_.size(), team, [&](std::size_t first, std::size_t end, std::size_t) {
    for (std::size_t cell = first; cell < end; ++cell)
      if (kind_of_[cell] >= 0) {
        const auto at = static_cast<std::int64_t>(cell);
        const Matrix6 C = stiffness(at);
        kinds_[kind_of_[cell]] =
            kind_for(C, Matrix6(C.inverse()), thin_axes(scene.specimen, grid_.cell_at(at)));
      }
  });
}

/// Stand-in for kinds, which are not known yet.
void LatticeElasticity::find_thin(ThreadTeam& team) {
  few_kinds_of_.assign(end_cell_ - first_cell_, 0);
  for_parts(few_kinds_of_.size(), team, [&](std::size_t first, std::size_t end, std::size_t) {
    Index3 at = grid_.cell_at(first_cell_ + static_cast<std::int64_t>(first));
    for (std::size_t i = first; i < end; ++i) {
      if (scene_.specimen.is_matter(first_cell_ + static_cast<std::int64_t>(i)))
        few_kinds_of_[i] = thin_axes(scene_.specimen, at);
      for (std::size_t a = 0; ++at[a] == grid_.cells()[a] && a < 2; ++a)
        at[a] = 0;
    }
  });
}

/// Stiffness and compliance of the kinds: those of their materials, turned.
class LatticeElasticity::Stiffnesses {
public:
  explicit Stiffnesses(const LatticeElasticity& of) : of_(of), scene_(of.scene_) {
    for (const Material& material : scene_.materials) {
      C_.push_back(stiffness(material.elasticity));
      S_.push_back(C_.back().inverse());
    }
  }
  Kind kind_of(std::int64_t cell, std::uint8_t thin) const {
    const std::size_t material = scene_.specimen.material(cell);
    if (scene_.materials[material].elasticity.is_isotropic())
      return kind_for(C_[material], S_[material], thin);
    const Eigen::Matrix3d axes = scene_.material_axes(cell);
    return kind_for(turned(C_[material], axes), turned_compliance(S_[material], axes), thin);
  }

private:
  Kind kind_for(const Matrix6& C, const Matrix6& S, std::uint8_t thin) const {
    if (of_.grid_.dimension() == 3)
      return of_.kind_for(C, S, thin);
    const Eigen::MatrixXd reduced = reduced_stiffness(C, of_.grid_.dimension(), scene_.plane);
    Matrix6 of_reduced = Matrix6::Identity();
    of_reduced.topLeftCorner(reduced.rows(), reduced.cols()) = reduced.inverse();
    return of_.kind_for(reduced, of_reduced, thin);
  }

  const LatticeElasticity& of_;
  const Scene& scene_;
  std::vector<Matrix6> C_, S_; ///< of materials
};

double LatticeElasticity::Kind::largest_mean() const {
  double largest = 0;
  for (int p = 0; p < 6; ++p)
    largest = std::max(largest, mean_at(p, p));
  return largest;
}

/// In the order of cells. @param first of every kind @return false where there are more than `most`
bool LatticeElasticity::number_kinds(std::int64_t begin, std::int64_t end, std::size_t most,
                                     List<FirstOfKind>& first) {
  const Specimen& body = scene_.specimen;
  std::unordered_map<Matter, std::int32_t, HashOfMatter> known;
  constexpr std::size_t n_thin = corners_of_cell<3>; // as many sets of axes
  std::vector<std::int32_t> known_without_direction(n_thin * scene_.materials.size(), -1);
  std::vector<bool> has_direction;
  for (const Material& material : scene_.materials)
    has_direction.push_back(!body.fibres.empty() && !material.elasticity.is_isotropic());
  first.clear();
  for (std::int64_t cell = begin; cell < end; ++cell) {
    if (!body.is_matter(cell))
      continue;
    const std::size_t material = body.material(cell);
    const auto thin =
        is_known(cell) ? static_cast<std::uint8_t>(kind_number(cell)) : thin_axes(body, grid_.cell_at(cell));
    const auto next = static_cast<std::int32_t>(first.size());
    std::int32_t kind = next;
    if (has_direction[material]) {
      Matter matter{static_cast<float>(material), 0, 0, 0, static_cast<float>(thin)};
      for (std::size_t a = 0; a < 3; ++a)
        matter[a + 1] = static_cast<float>(body.fibre_of(cell)[a]);
      kind = known.try_emplace(matter, next).first->second;
    } else if (std::int32_t& of_thin = known_without_direction[n_thin * material + thin]; of_thin < 0)
      of_thin = next;
    else
      kind = of_thin;
    if (kind == next)
      first.push_back({cell, thin});
    if (first.size() > most)
      return false;
    if (is_known(cell))
      set_kind(cell, kind);
  }
  return true;
}

void LatticeElasticity::find_kinds(ThreadTeam& team) {
  List<FirstOfKind> first;
  const bool knows_all = end_cell_ - first_cell_ == grid_.n_cells();
  find_thin(team);
  has_few_kinds_ = knows_all || number_kinds(0, grid_.n_cells(), few_kinds, first);
  if (!has_few_kinds_)
    find_thin(team);
  if (knows_all || !has_few_kinds_)
    number_kinds(first_cell_, end_cell_, static_cast<std::size_t>(grid_.n_cells()), first);
  const Stiffnesses stiffnesses(*this);
  kinds_.resize(first.size());
  const int n_kinds = static_cast<int>(kinds_.size());
  team.run((n_kinds + rows_per_item - 1) / rows_per_item, [&](int item, int) {
    const int end = std::min((item + 1) * rows_per_item, n_kinds);
    for (auto i = static_cast<std::size_t>(item * rows_per_item); i < static_cast<std::size_t>(end); ++i)
      kinds_[i] = stiffnesses.kind_of(first[i].cell, first[i].thin);
  });
  if (kinds_.size() == 1)
    few_kinds_of_ = {};
}

void LatticeElasticity::set_kind(std::int64_t cell, std::int32_t kind) {
  if (kind > std::numeric_limits<std::uint8_t>::max() && kind_of_.empty()) {
    kind_of_.assign(few_kinds_of_.begin(), few_kinds_of_.end());
    few_kinds_of_ = {};
  }
  if (kind_of_.empty())
    few_kinds_of_[cell - first_cell_] = static_cast<std::uint8_t>(kind);
  else
    kind_of_[cell - first_cell_] = kind;
}

void LatticeElasticity::renew() {
  const Stiffnesses stiffnesses(*this);
  std::vector<bool> is_renewed(kinds_.size(), false);
  std::size_t left = kinds_.size();
  for (std::int64_t cell = first_cell_; cell < end_cell_ && left > 0; ++cell) {
    if (!scene_.specimen.is_matter(cell))
      continue;
    const auto kind = static_cast<std::size_t>(kind_number(cell));
    if (is_renewed[kind])
      continue;
    kinds_[kind] = stiffnesses.kind_of(cell, kinds_[kind].thin);
    is_renewed[kind] = true;
    --left;
  }
}

/// @param S compliance, in 3D all of it, else its diagonal counts alone
template<class Stiffness>
LatticeElasticity::Kind LatticeElasticity::kind_for(const Stiffness& C, const Matrix6& S,
                                                    std::uint8_t thin) const {
  const int d = grid_.dimension();
  const Vec3& h = grid_.spacing();
  double volume = 1;
  for (int a = 0; a < d; ++a)
    volume *= h[a];
  Kind kind;
  const auto mean = [&](int p, int q) -> double& { return kind.mean[mean_coefficient(p, q)]; };
  for (int p = 0; p < C.rows(); ++p)
    for (int q = p; q < C.cols(); ++q)
      mean(p, q) = volume * C(p, q);
  for (int a = 0; a < d; ++a) {
    const auto i = static_cast<std::size_t>(a);
    mean(a, a) -= alpha * volume / S(a, a);
    kind.edge[i] = alpha * volume / (1 << (d - 1)) / S(a, a) / (h[i] * h[i]);
    if (d == 3)
      kind.shear[i] = volume / 12 / S(3 + a, 3 + a); // rows 23 13 12: the pair whose third axis is a
  }
  kind.thin = thin;
  kind.bending.assign(thin != 0 ? 3 : 0, Eigen::Matrix3d::Zero());
  for (int c = 0; c < 3; ++c)
    if ((thin >> c & 1) != 0)
      kind.bending[c] = volume / 12 * bending_beyond_links(S, c);
  return kind;
}

/// Differences along every edge, forces at the ends of edges, and their sums. Corners are numbered by bits x
/// y z; u and force are stored component by component.
template<int dimension>
void LatticeElasticity::add_cell(const Kind& kind, const double* u, double* force) const {
  constexpr int corners = corners_of_cell<dimension>, edges = corners / 2,
                n_strains = dimension * (dimension + 1) / 2;
  const Vec3& h = grid_.spacing();
  double difference[dimension][dimension][edges]; // [axis][component][edge], over h
  double gradient[dimension][dimension];          // [axis][component], mean
  constexpr auto tail = edge_tails<dimension>();
  for (int a = 0; a < dimension; ++a) {
    for (int b = 0; b < dimension; ++b) {
      double sum = 0;
      for (int k = 0; k < edges; ++k) {
        const double e = (u[b * corners + (tail[a][k] | 1 << a)] - u[b * corners + tail[a][k]]) / h[a];
        difference[a][b][k] = e;
        sum += e;
      }
      gradient[a][b] = sum / edges;
    }
  }
  double strain[n_strains], stress[n_strains];
  for (int a = 0; a < dimension; ++a) {
    strain[a] = gradient[a][a];
    for (int b = a + 1; b < dimension; ++b)
      strain[shear_row<dimension>(a, b)] = gradient[a][b] + gradient[b][a];
  }
  for (int i = 0; i < n_strains; ++i) {
    stress[i] = 0;
    for (int j = 0; j < n_strains; ++j)
      stress[i] += kind.mean_at(i, j) * strain[j];
  }
  // V / 12 G D_c gamma_ab, for each third axis c
  double twist[3] = {0, 0, 0};
  double bend[3][3] = {}; // [axis across][axis of edges], of plates beyond that of beams
  if constexpr (dimension == 3)
    for (int c = 0; c < 3; ++c) {
      const int a = (c + 1) % 3, b = (c + 2) % 3;
      double jump = 0;
      for (int k = 0; k < edges; ++k) {
        jump += (tail[a][k] & 1 << c ? 0.5 : -0.5) * difference[a][b][k];
        jump += (tail[b][k] & 1 << c ? 0.5 : -0.5) * difference[b][a][k];
      }
      twist[c] = kind.shear[c] * jump;
      if ((kind.thin >> c & 1) != 0) {
        Eigen::Vector3d faces(0, 0, jump);
        for (int k = 0; k < edges; ++k) {
          faces[0] += (tail[a][k] & 1 << c ? 0.5 : -0.5) * difference[a][a][k];
          faces[1] += (tail[b][k] & 1 << c ? 0.5 : -0.5) * difference[b][b][k];
        }
        const Eigen::Vector3d moment = kind.bending[c] * faces;
        bend[c][a] = moment[0];
        bend[c][b] = moment[1];
        twist[c] += moment[2];
      }
    }
  for (int a = 0; a < dimension; ++a)
    for (int b = 0; b < dimension; ++b) {
      const double step = h[a];
      const double even =
          stress[a == b ? a : shear_row<dimension>(a < b ? a : b, a < b ? b : a)] / edges / step;
      const int c = dimension == 3 && a != b ? 3 - a - b : 0;
      for (int k = 0; k < edges; ++k) {
        double pull = even;
        if (a == b) {
          pull += kind.edge[a] * step * difference[a][a][k];
          if (dimension == 3 && kind.thin != 0)
            for (int across = 0; across < 3; ++across)
              pull += (tail[a][k] & 1 << across ? 0.5 : -0.5) * bend[across][a] / step;
        } else if (dimension == 3)
          pull += (tail[a][k] & 1 << c ? 0.5 : -0.5) * twist[c] / step;
        force[b * corners + (tail[a][k] | 1 << a)] += pull;
        force[b * corners + tail[a][k]] -= pull;
      }
    }
}

LatticeElasticity::Nodes<const double> LatticeElasticity::all_of(const Displacement& u) const {
  Nodes<const double> all;
  all.first_node = first_node_;
  for (std::size_t c = 0; c < u.n_components(); ++c)
    all.values[c] = u.component(c).data();
  return all;
}

template<int dimension>
void LatticeElasticity::apply_to_layer(const Nodes<const double>& u, const Nodes<double>& forces,
                                       int layer) const {
  constexpr int corners = corners_of_cell<dimension>;
  const Index3& cells = grid_.cells();
  const std::int64_t in_layer = grid_.n_cells() / cells[dimension - 1], first = layer * in_layer;
  std::int64_t offset[corners]; // of the corners from the first one, in the grid's numbers
  for (int corner = 0; corner < corners; ++corner) {
    offset[corner] = 0;
    for (int a = 0; a < dimension; ++a)
      if (corner & 1 << a)
        offset[corner] += grid_.stride(a);
  }
  const auto add_at = [&](std::int64_t cell, std::int64_t node) {
    double of_u[dimension * corners], of_force[dimension * corners] = {};
    bool is_moved = false; // at the start of a solve most nodes are at rest
    for (int b = 0; b < dimension; ++b)
      for (int corner = 0; corner < corners; ++corner) {
        const double value = *u.at(static_cast<std::size_t>(b), node + offset[corner]);
        of_u[b * corners + corner] = value;
        is_moved = is_moved || value != 0;
      }
    if (!is_moved)
      return;
    add_cell<dimension>(kind(cell), of_u, of_force);
    const double of_kind = weight(cell);
    for (int b = 0; b < dimension; ++b)
      for (int corner = 0; corner < corners; ++corner)
        *forces.at(static_cast<std::size_t>(b), node + offset[corner]) +=
            of_kind * of_force[b * corners + corner];
  };
  const std::int64_t in_row = std::min(in_layer, std::int64_t{cells[0]}); // in 1D layers are cells
  const auto is_plain = [&](std::int64_t cell) {
    return dimension == 3 && !scene_.specimen.has_weights() && kind(cell).thin == 0;
  };
  for (std::int64_t row = first; row < first + in_layer; row += in_row) {
    const std::int64_t node = grid_.corner(grid_.cell_at(row), 0);
    for (std::int64_t x = 0, end = 0; x < in_row; x = end) {
      end = x + 1;
      if (!scene_.specimen.is_matter(row + x))
        continue;
      const std::int32_t number = kind_number(row + x);
      while (end < in_row && scene_.specimen.is_matter(row + end) && kind_number(row + end) == number)
        ++end;
      if (end - x >= fewest_cells_of_run && is_plain(row + x))
        add_run(u, forces, kind(row + x), node + x, end - x);
      else
        for (std::int64_t i = x; i < end; ++i)
          add_at(row + i, node + i);
    }
  }
}

void LatticeElasticity::add_run(const Nodes<const double>& u, const Nodes<double>& forces, const Kind& of,
                                std::int64_t node, std::int64_t n) const {
  const auto is_at_rest = [&](std::size_t c, std::int64_t row) {
    const double* const first = u.at(c, node + row);
    return std::all_of(first, first + n + 1, [](double value) { return value == 0; });
  };
  bool rests = true; // before the first step only prescribed nodes have moved
  for (const std::int64_t row :
       {std::int64_t{0}, grid_.stride(1), grid_.stride(2), grid_.stride(1) + grid_.stride(2)})
    for (std::size_t c = 0; c < 3 && rests; ++c)
      rests = is_at_rest(c, row);
  if (rests)
    return;
  LatticeRun run;
  run.cells = static_cast<int>(n);
  run.mean = of.mean.data();
  run.edge = of.edge.data();
  run.shear = of.shear.data();
  run.next_y = grid_.stride(1);
  run.next_z = grid_.stride(2);
  for (std::size_t c = 0; c < 3; ++c) {
    run.per_length[c] = 1 / grid_.spacing()[c];
    run.u[c] = u.at(c, node);
    run.forces[c] = forces.at(c, node);
  }
  add_run_forces(run);
}

void LatticeElasticity::apply(const Displacement& u, Displacement& forces, ThreadTeam& team) const {
  std::ranges::fill(forces.values(), 0.0);
  const Nodes<const double> from = all_of(u);
  Nodes<double> to;
  for (std::size_t c = 0; c < forces.n_components(); ++c)
    to.values[c] = forces.component(c).data();
  const int d = grid_.dimension(), layers = grid_.cells()[d - 1];
  run_slabs(team, layers, [&](int layer) {
    if (d == 1)
      apply_to_layer<1>(from, to, layer);
    else if (d == 2)
      apply_to_layer<2>(from, to, layer);
    else
      apply_to_layer<3>(from, to, layer);
  });
  for (const NodalSpring& spring : springs_) {
    const Vec3 pull = pull_of(spring, u);
    for (int b = 0; b < d; ++b)
      forces(b, spring.node) -= pull[b];
  }
}

template<class Planes>
void LatticeElasticity::visit_windows(const Planes& planes_of, ThreadTeam& team, PlaneRange asked,
                                      const std::function<void(const Window&)>& visit) const {
  // The layer below a window is of an even number, which apply() takes before the one above it.
  constexpr int planes_of_first = planes_per_window - 1;
  const int planes = grid_.nodes()[2];
  const std::int64_t in_plane = grid_.n_nodes() / planes;
  // Layers of cells reach one plane beyond the window, which is the next one's first.
  const std::int64_t stride = (std::min(planes, planes_per_window) + 1) * in_plane;
  List<double> memory(static_cast<std::size_t>(3 * stride), 0);
  Nodes<double> to{{memory.data(), memory.data() + stride, memory.data() + 2 * stride}, 0};
  const int begin = std::max(0, asked.first - 1); // where a window of the whole grid begins
  for (int first = begin, end = first + (first == 0 ? planes_of_first : planes_per_window); first < asked.end;
       first = end, end += planes_per_window) {
    end = std::min(end, asked.end);
    to.first_node = first * in_plane;
    const int end_layer = std::min(end, planes - 1);
    const std::optional<Nodes<const double>> u = planes_of(first, std::min(end + 1, planes));
    for (const int parity : {0, 1}) {
      const int least = first + (first % 2 == parity ? 0 : 1);
      team.run(u ? std::max(0, (end_layer - least + 1) / 2) : 0,
               [&](int item, int) { apply_to_layer<3>(*u, to, least + 2 * item); });
    }
    Window window{first, end, first * in_plane, (end - first) * in_plane, {}, {}};
    for (std::size_t c = 0; c < 3; ++c) {
      window.u[c] = u ? u->at(c, window.first_node) : nullptr;
      window.forces[c] = to.values[c];
    }
    for (const NodalSpring& spring : springs_) {
      const std::int64_t at = spring.node - window.first_node;
      if (!u || at < 0 || at >= window.n_nodes)
        continue;
      const Eigen::Vector3d pull =
          spring.stiffness * Eigen::Vector3d(window.u[0][at], window.u[1][at], window.u[2][at]);
      for (std::size_t b = 0; b < 3; ++b)
        to.values[b][at] += pull[static_cast<Eigen::Index>(b)];
    }
    visit(window);
    team.run(3, [&](int b, int) {
      double* const of = to.values[b];
      std::copy_n(of + window.n_nodes, end < asked.end ? in_plane : 0, of);
      std::fill(of + in_plane, of + stride, 0.0);
    });
  }
}

void LatticeElasticity::for_each_window(const Displacement& u, ThreadTeam& team, PlaneRange planes,
                                        const std::function<void(const Window&)>& visit) const {
  visit_windows([&](int, int) { return std::optional(all_of(u)); }, team, planes, visit);
}

void LatticeElasticity::for_each_window(const PutPlanes& put, ThreadTeam& team, PlaneRange planes,
                                        const std::function<void(const Window&)>& visit) const {
  const std::int64_t in_plane = grid_.n_nodes() / grid_.nodes()[2],
                     stride = (std::min(grid_.nodes()[2], planes_per_window) + 1) * in_plane;
  List<double> memory(static_cast<std::size_t>(3 * stride), 0);
  const Nodes<double> of{{memory.data(), memory.data() + stride, memory.data() + 2 * stride}, 0};
  bool is_zero = true;
  visit_windows(
      [&](int first, int end) {
        if (!is_zero)
          std::ranges::fill(memory, 0.0);
        is_zero = !put(first, end, of.values);
        return is_zero ? std::nullopt
                       : std::optional(Nodes<const double>{{of.values[0], of.values[1], of.values[2]},
                                                           first * in_plane});
      },
      team, planes, visit);
}

template<int dimension>
Eigen::Matrix<double, 3, 1 << dimension>
LatticeElasticity::cell_forces(std::int64_t cell, const Eigen::Matrix<double, 3, 1 << dimension>& u) const {
  constexpr int corners = corners_of_cell<dimension>;
  double of_u[dimension * corners], of_force[dimension * corners] = {};
  for (int b = 0; b < dimension; ++b)
    for (int corner = 0; corner < corners; ++corner)
      of_u[b * corners + corner] = u(b, corner);
  add_cell<dimension>(kind(cell), of_u, of_force);
  Eigen::Matrix<double, 3, corners> force = Eigen::Matrix<double, 3, corners>::Zero();
  for (int b = 0; b < dimension; ++b)
    for (int corner = 0; corner < corners; ++corner)
      force(b, corner) = weight(cell) * of_force[b * corners + corner];
  return force;
}
template Eigen::Matrix<double, 3, 2>
LatticeElasticity::cell_forces<1>(std::int64_t cell, const Eigen::Matrix<double, 3, 2>& u) const;
template Eigen::Matrix<double, 3, 4>
LatticeElasticity::cell_forces<2>(std::int64_t cell, const Eigen::Matrix<double, 3, 4>& u) const;
template Eigen::Matrix<double, 3, 8>
LatticeElasticity::cell_forces<3>(std::int64_t cell, const Eigen::Matrix<double, 3, 8>& u) const;

/// The diagonal of one cell of every kind by its unit displacements, then summed over cells.
Displacement LatticeElasticity::diagonal() const {
  const int d = grid_.dimension(), corners = 1 << d;
  const auto of_cell = [&](const Kind& kind) {
    std::vector<double> diagonal;
    for (int i = 0; i < d * corners; ++i) {
      double unit[24] = {}, force[24] = {};
      unit[i] = 1;
      if (d == 1)
        add_cell<1>(kind, unit, force);
      else if (d == 2)
        add_cell<2>(kind, unit, force);
      else
        add_cell<3>(kind, unit, force);
      diagonal.push_back(force[i]);
    }
    return diagonal;
  };
  std::vector<std::vector<double>> of_kind;
  for (const Kind& kind : kinds_)
    of_kind.push_back(of_cell(kind));
  Displacement sum(grid_);
  std::vector<std::size_t> offset; // of the corners from the first one, in the grid's numbers
  for (int corner = 0; corner < corners; ++corner) {
    offset.push_back(0);
    for (int a = 0; a < d; ++a)
      offset.back() += (corner & 1 << a) != 0 ? static_cast<std::size_t>(grid_.stride(a)) : 0;
  }
  for (std::int64_t row = 0; row < grid_.n_cells(); row += grid_.cells()[0]) {
    const auto first = static_cast<std::size_t>(grid_.corner(grid_.cell_at(row), 0));
    for (std::int64_t x = 0; x < grid_.cells()[0]; ++x) {
      if (!scene_.specimen.is_matter(row + x))
        continue;
      const double part = weight(row + x);
      const double* value = of_kind[kind_number(row + x)].data();
      for (int b = 0; b < d; ++b)
        for (const std::size_t corner : offset)
          sum(b, first + static_cast<std::size_t>(x) + corner) += part * *value++;
    }
  }
  for (const NodalSpring& spring : springs_)
    for (int b = 0; b < d; ++b)
      sum(b, spring.node) += spring.stiffness(b, b);
  return sum;
}

} // namespace maille::deform
