#pragma once
/// Inner loops of the componentwise multigrid in float32, compiled for every vector instruction set.
///
/// Each works on one plane of a level. Rows are padded to whole lines of line_of_floats; padding has no links
/// and stays 0.

#include "lattice/field_memory.hpp"

#include <cstdint>

namespace maille::deform {

/// The operator of one level: A u at a node = sum over its links of weight (u_node - u_neighbour) + anchor
/// u_node.
///
/// A box stores factors of its axes instead of weights: the link from (i, j, k) along x weighs x_link[i]
/// y_mass[j] z_mass[k], and so on. Along each axis entry -1 and the last of `link` are 0.
struct ComponentwiseOperator {
  int nodes[3] = {1, 1, 1};
  std::int64_t row_stride = 0, slab_stride = 0;
  /// Per row j + nodes[1] k: the inverse of the diagonal, 0 at fixed nodes; nullptr for rows without free
  /// nodes.
  const float* const* inverse_diagonal = nullptr;

  /// Per row: anchors of the nodes (componentwise_level.hpp), or nullptr without anchors; nullptr as a whole
  /// if no row has any.
  const float* const* anchor = nullptr;

  const float* axis_link[3] = {}; ///< of a box
  const float* axis_mass[3] = {}; ///< of a box
  const float* link[3] = {};      ///< of any other body: per node, of the link to the next; nullptr on a box
};

/// u = weight f / diagonal at free nodes, 0 elsewhere: a Jacobi step from 0.
void start_relaxation(const ComponentwiseOperator& A, int z, float weight, const float* f, float* u);
/// next = u + weight (f - A u) / diagonal: a Jacobi step of A u = f. At fixed nodes next = u.
void relax_plane(const ComponentwiseOperator& A, int z, float weight, const float* f, const float* u,
                 float* next);
/// r = f - A u at free nodes, 0 elsewhere.
void find_residual(const ComponentwiseOperator& A, int z, const float* f, const float* u, float* r);
/// q = A p at free nodes, 0 elsewhere. @return the plane's part of p . q
double apply_and_dot(const ComponentwiseOperator& A, int z, const float* p, float* q);

/// The plane's part of a . b.
double dot(const ComponentwiseOperator& A, int z, const float* a, const float* b);
/// p = v + beta p. @return the largest |v| in the plane
double update_direction(const ComponentwiseOperator& A, int z, const float* v, float beta, float* p);
/// x += alpha scale p, r -= alpha q; x is dense and in float64. @return the largest |alpha p| in the plane
double take_step(const ComponentwiseOperator& A, int z, double alpha, double scale, const float* p,
                 const float* q, double* x, float* r);

/// Nodes of one axis and of the next coarser level. Coarse node I sits on fine node 2 I; the last sits on the
/// last, and its interval spans three if the number of intervals is odd.
struct AxisTransfer {
  int n_fine = 1, n_coarse = 1;
  bool is_coarsened = false;
  const int* first = nullptr;   ///< per coarse node: the first fine one in its support
  const int* count = nullptr;   ///< and how many there are, at most most_in_support
  const float* hat = nullptr;   ///< their weights, most_in_support per coarse node
  const int* left = nullptr;    ///< per fine node: the coarse node at or before it
  const float* right = nullptr; ///< and the weight of the one after
};
inline constexpr int most_in_support = 5;

/// Coarse plane `z` of the transposed interpolation of r. @param scratch as long as a fine row and two lines
void restrict_plane(const ComponentwiseOperator& coarse, const ComponentwiseOperator& fine,
                    const AxisTransfer* transfer, int z, const float* r, float* f_coarse, float* scratch);
/// Fine plane `z` of u += interpolation of u_coarse at free nodes, or u = it if `replaces`.
/// @param scratch as long as a fine row and a coarse one and four lines
void prolong_plane(const ComponentwiseOperator& coarse, const ComponentwiseOperator& fine,
                   const AxisTransfer* transfer, int z, const float* u_coarse, bool replaces, float* u,
                   float* scratch);

} // namespace maille::deform
