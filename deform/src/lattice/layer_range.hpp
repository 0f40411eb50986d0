#pragma once
/// Parts of a 3D grid across z.

namespace maille::deform {

/// Of layers of cells.
struct LayerRange {
  int first = 0, end = 0;
};
/// Of planes of nodes; layer z is between planes z and z + 1.
struct PlaneRange {
  int first = 0, end = 0;
};

} // namespace maille::deform
