#pragma once
/// The lattice operator of a box of one material, as sums of products of operators along its axes, and inner
/// loops on it, compiled for every vector instruction set.
///
/// Each loop works on one plane z of a level. In float32, rows are padded to whole lines of line_of_floats
/// with nodes that stay 0, and the three components follow one another.

#include "elastic/componentwise/componentwise_kernel.hpp"
#include "maille/base/grid.hpp"

#include <Eigen/Core>

#include <cstdint>

namespace maille::deform {

/// Along one axis, a cell of length h between two nodes with values u, v contributes to the forces at both
///
///   L, link:  (u - v) H / h, (v - u) H / h      M, mass:  (u + v) h / H at both
///   D, difference:  v - u at both               T, its transpose:  -(u + v), u + v
///   E, share:  u h / (2 H), v h / (2 H)
///
/// where H is the regular spacing of the level. The operator of LatticeElasticity is then, for the force
/// along i and the displacement along j,
///
///   sum_a strain[i][a][j][a] L_a M_b M_c  +  sum over a != b of strain[i][a][j][b] T_a D_b M_c
///
/// with edge[i] L_i E_b E_c and twist_self[i] M_i L_b L_c added where i = j, and twist_pair[c] T_j D_i L_c
/// where i != j and c is the third axis. In a box that is thin along c, bending[c] stands as strain does, of
/// components and axes other than c, with L_c in place of M_c. (Of irregular cells the difference across the
/// third axis is thus weighed by H / h: they occur on coarse levels only, which need not be exact.)
///
/// Source  docs/theory.md, section 3 (LAT)
struct BoxCoefficients {
  double strain[3][3][3][3] = {}; ///< [i][a][j][b], of d_a u_i times d_b u_j
  double edge[3] = {};
  double twist_self[3] = {};
  double twist_pair[3] = {};
  double bending[3][3][3][3][3] = {}; ///< [c][i][a][j][b]
  bool bends[3] = {false, false, false};
  bool is_aligned = true; ///< normal strains and the three shears are not coupled with one another

  BoxCoefficients() = default;
  /// @param C 6 x 6 stiffness, order 11 22 33 23 13 12 [Pa]; @param spacing H along the axes [m]; @param unit
  /// what the coefficients are counted in [N/m]; @param thin axes along which the body is thin, by bits
  BoxCoefficients(const Eigen::Matrix<double, 6, 6>& C, const Vec3& spacing, double unit, std::uint8_t thin);
  bool is_thin() const { return bends[0] || bends[1] || bends[2]; }
};

/// One axis of a level, per cell: its length over the regular one, and the inverse. Entries -1 and n_cells
/// are 0.
template<class T>
struct BoxAxis {
  const T* mass = nullptr;
  const T* link = nullptr;
};

/// The operator of one level.
struct BoxOperator {
  int nodes[3] = {1, 1, 1};
  std::int64_t row_stride = 0, slab_stride = 0, component_stride = 0; ///< of float32 fields
  BoxCoefficients coefficients;
  BoxAxis<double> axis[3];
  /// Those of x, padded with zeros to whole lines and one more.
  BoxAxis<float> x_axis;
  /// Lines of 16 nodes from 1 to before this one touch only regular cells.
  int end_of_regular_lines = 1;
  /// Per component, row j + nodes[1] k: the inverse of the diagonal, 0 where a component is fixed.
  const float* const* inverse[3] = {};
};

/// Scratch memory of the loops, for one thread [bytes].
std::int64_t box_scratch_bytes(const BoxOperator& A);

/// f -= step q; then u = weight f / diagonal where components are free, 0 elsewhere: a Jacobi step from 0. q
/// may be u.
void start_box(const BoxOperator& A, int z, float weight, float step, const float* q, float* f, float* u);
/// next = u + weight (f - A u) / diagonal: a Jacobi step of A u = f. Where components are fixed, next = u.
void relax_box(const BoxOperator& A, int z, float weight, const float* f, const float* u, float* next,
               void* scratch);
/// r = f - A u where components are free, 0 elsewhere.
void find_box_residual(const BoxOperator& A, int z, const float* f, const float* u, float* r, void* scratch);
/// f = pulls - A u where components are free, 0 elsewhere, with A u in float64. @param pulls loads; null:
/// none
/// @return the plane's part of u . A u, of all nodes
double begin_box(const BoxOperator& A, int z, const float* pulls, const float* u, float* f, void* scratch);
/// q = A p where components are free, 0 elsewhere. @return the plane's part of p . q
double apply_box_and_dot(const BoxOperator& A, int z, const float* p, float* q, void* scratch);
/// forces = A u in float64, everywhere. @param u dense, [component][node]; @param forces one plane, likewise
void apply_box(const BoxOperator& A, int z, const double* u, double* forces, void* scratch);

/// The plane's part of a . b.
double dot_box(const BoxOperator& A, int z, const float* a, const float* b);
/// x += step p, and then p = v + beta p.
void update_box_direction(const BoxOperator& A, int z, const float* v, float beta, float step, float* p,
                          float* x);

/// Pending steps along a direction.
struct BoxSteps {
  float of_state = 0, of_residual = 0;
};
/// x += steps.of_state p; f -= steps.of_residual q; then u = scale x, or u += scale x if `adds`. u is dense
/// and in float64, [component][node].
/// @return the plane's part of x . f
double finish_box(const BoxOperator& A, int z, const BoxSteps& steps, const float* p, const float* q,
                  float* x, float* f, double scale, bool adds, double* u);

} // namespace maille::deform
