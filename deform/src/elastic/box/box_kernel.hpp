#pragma once
/// The innermost loops of elasticity on a box of one material, for every kind of vector that the machine may
/// have.
///
/// All of them work on one plane z of one level. In float32 rows are padded to whole lines of line_of_floats
/// with nodes that never move and stay 0, and the three components of a field follow one another.

#include "elastic/box/box_coefficients.hpp"
#include "elastic/componentwise/componentwise_kernel.hpp"

#include <cstdint>

namespace maille::deform {

/// One axis of a level: of each cell the length over the regular one, and the inverse. Entries -1 and n_cells
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
  /// Lines of 16 nodes from 1 to before this one have only regular cells about them.
  int end_of_regular_lines = 1;
  /// Per component, row j + nodes[1] k: the inverse of the operator's diagonal, 0 where a node may not move.
  const float* const* inverse[3] = {};
};

/// What the loops need beside their arguments, for one thread [bytes].
std::int64_t box_scratch_bytes(const BoxOperator& A);

/// f -= step q, and then u = weight f / diagonal where nodes may move, 0 elsewhere: a Jacobi step from
/// nothing. q may be u.
void start_box(const BoxOperator& A, int z, float weight, float step, const float* q, float* f, float* u);
/// next = u + weight (f - A u) / diagonal: a Jacobi step of A u = f. Where nodes may not move, next = u.
void relax_box(const BoxOperator& A, int z, float weight, const float* f, const float* u, float* next,
               void* scratch);
/// r = f - A u where nodes may move, 0 elsewhere.
void find_box_residual(const BoxOperator& A, int z, const float* f, const float* u, float* r, void* scratch);
/// f = pulls - A u where nodes may move, 0 elsewhere, with A u in float64. @param pulls null: none.
/// @return the plane's part of u . A u, of all nodes
double begin_box(const BoxOperator& A, int z, const float* pulls, const float* u, float* f, void* scratch);
/// q = A p where nodes may move, 0 elsewhere. @return the plane's part of p . q
double apply_box_and_dot(const BoxOperator& A, int z, const float* p, float* q, void* scratch);
/// forces = A u in float64, everywhere. @param u dense, [component][node]; @param forces one plane, likewise
void apply_box(const BoxOperator& A, int z, const double* u, double* forces, void* scratch);

/// The plane's part of a . b.
double dot_box(const BoxOperator& A, int z, const float* a, const float* b);
/// x += step p, and then p = v + beta p.
void update_box_direction(const BoxOperator& A, int z, const float* v, float beta, float step, float* p,
                          float* x);

/// Steps along a direction that are still to be taken.
struct BoxSteps {
  float of_state = 0, of_residual = 0;
};
/// x += steps.of_state p, f -= steps.of_residual q, and then u = scale x, or that added to it; u is dense and
/// in float64, [component][node].
/// @return the plane's part of x . f
double finish_box(const BoxOperator& A, int z, const BoxSteps& steps, const float* p, const float* q,
                  float* x, float* f, double scale, bool adds, double* u);

/// u += of_u p, r += of_r q; u and r are dense and in float64, [component][node].
void move_box(const BoxOperator& A, int z, double of_u, const float* p, double* u, double of_r,
              const float* q, double* r);
/// to = factor from, which is dense and in float64, [component][node].
void narrow_box(const BoxOperator& A, int z, double factor, const double* from, float* to);

} // namespace maille::deform
