#pragma once
/// Parts of a 3D grid across z.

namespace maille::deform {

/// Range of layers of cells.
struct LayerRange {
  int first = 0, end = 0;
};
/// Range of planes of nodes; layer z is between planes z and z + 1.
struct PlaneRange {
  int first = 0, end = 0;
};

} // namespace maille::deform
