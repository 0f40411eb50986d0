#pragma once
/// The arrays of one object, as small as its scene allows.

#include "lattice/field_memory.hpp"
#include "maille/deform/plan.hpp"
#include "maille/scene/answer.hpp"

#include <array>
#include <cstdint>

namespace maille::deform {

/// The displacement of every node, and what else a scene makes necessary.
///
/// | array | present | size |
/// | --- | --- | --- |
/// | displacement, one per component | always | float32 per node, rows padded to whole cache lines |
/// | matter | where the body does not fill its grid | one bit a node |
/// | held, one per component | where a hold keeps that component somewhere | one bit a node |
///
/// Nothing is stored per link: limits are the business of LinkLimits, which is one small table where they are
/// the same everywhere, and of the scene, whose material numbers are one byte a cell where there are several.
///
/// A displacement is offset(component) [float64] plus the stored number [float32]. When a drag carries the
/// whole body along, the offset takes that part, so what is stored stays as small as the limits keep
/// differences within the body, and a body dragged far away is as accurate as one at home. Displacements are
/// in the object's frame [m].
class Body {
public:
  /// A body at rest. @param scene must outlive the body
  explicit Body(const Scene& scene);

  const Scene& scene() const { return *scene_; }
  const Grid& grid() const { return scene_->specimen.grid; }
  int dimension() const { return grid().dimension(); }
  bool fills_its_grid() const { return matter_.size() == 0; }

  /// Where the stored numbers of a component are. Numbers at grid points without matter mean nothing.
  Field<float> field(int component);
  Field<const float> field(int component) const;
  double offset(int component) const { return offset_[component]; }
  void set_offset(int component, double offset) { offset_[component] = offset; }

  bool is_matter(std::int64_t node) const { return fills_its_grid() || bit(matter_, node); }
  bool is_held(int component, std::int64_t node) const {
    const auto& bits = held_[component];
    return bits.size() > 0 && bit(bits, node);
  }
  /// Displacement of a node of the body [m].
  double displacement(int component, const Index3& node) const;
  /// Displacement of all nodes; zero outside the body.
  Displacement displacement() const;
  /// The same, into a state that is zero and of the right size, or was filled from this body before.
  void copy_to(Displacement& state) const;

  /// Memory of such a body before it is made, array by array and in total.
  static Footprint footprint(const Scene& scene);

private:
  using Bits = AlignedArray<std::uint64_t>;
  static bool bit(const Bits& bits, std::int64_t i) { return bits[std::size_t(i) / 64] >> (i % 64) & 1; }
  static void set_bit(Bits& bits, std::int64_t i) {
    bits[std::size_t(i) / 64] |= std::uint64_t{1} << (i % 64);
  }

  const Scene* scene_;
  std::int64_t row_stride_ = 0;
  std::array<AlignedArray<float>, 3> displacement_;
  std::array<double, 3> offset_{};
  Bits matter_;
  std::array<Bits, 3> held_;
};

} // namespace maille::deform
