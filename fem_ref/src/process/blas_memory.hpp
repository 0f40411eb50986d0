#pragma once
/// Address space for OpenBLAS.

namespace maille::fem_ref {

/// Whether OpenBLAS has the buffer that it takes for its first product: where it cannot have it, it asks
/// again for ever. Takes it for OpenBLAS, which keeps it, if memory is limited (ulimit -v, -d); to be asked
/// before anything large takes what there is.
bool has_blas_memory();

} // namespace maille::fem_ref
