#pragma once
/// Loops over the entries of float32 fields, for every kind of vector that the machine may have.

#include <cstdint>

namespace maille::deform {

/// Entries of fields, all components after one another; `inverse` of the diagonal, 0 where a node may not
/// move. u = weight f / diagonal
void start_entries(std::int64_t n, float weight, const float* inverse, const float* f, float* u);
/// u += weight (f - Au) / diagonal
void relax_entries(std::int64_t n, float weight, const float* inverse, const float* f, const float* Au,
                   float* u);
/// Au = f - Au where nodes may move, 0 elsewhere
void subtract_entries(std::int64_t n, const float* inverse, const float* f, float* Au);
/// Ap = 0 where nodes may not move. @return p . Ap
double mask_and_dot_entries(std::int64_t n, const float* inverse, const float* p, float* Ap);
double dot_entries(std::int64_t n, const float* a, const float* b);
/// p = v + beta p
void direct_entries(std::int64_t n, const float* v, float beta, float* p);
/// r -= step q
void step_entries(std::int64_t n, float step, const float* q, float* r);

} // namespace maille::deform
