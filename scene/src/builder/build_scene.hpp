#pragma once
/// Implementation of SceneBuilder::build(): makes the parts of a scene one by one, with the functions of the
/// file readers.

#include "maille/scene/scene_builder.hpp"

#include "conditions/prescribe.hpp"
#include "maille/scene/measure/measure.hpp"
#include "read/reader.hpp"
#include "voxels/label_cells.hpp"

#include <fmt/format.h>

namespace maille {

class SceneBuilder::Assembly {
public:
  explicit Assembly(const SceneBuilder& asked) : asked_(asked), faults_("") {}

  /// @throws InputError
  SceneAndMeasures scene_and_measures();

private:
  SceneAndMeasures of_keys();
  std::vector<Measure> measures();
  bool make_body();
  bool make_box(const BoxBody& box);
  bool make_labelled(const LabelBody& labels);
  std::vector<reader::LabelRange> read_labels(const Image& image);
  void read_material_of_box();
  std::optional<std::uint8_t> material_number(const MaterialChoice& choice, const std::string& path);
  void place_fibres();
  void read_limits();
  void read_relaxation();
  void add_conditions();
  void read_condition(const Condition& condition, bool held, int number,
                      std::vector<reader::Condition>& conditions);
  void add_load(const Load& load, int number, const std::optional<reader::Region>& region);

  std::optional<reader::Region> region_of(const Where& where, const reader::Asked& asked);
  std::optional<reader::Region> region_of(const NodeList& list, const reader::Asked& asked);
  std::optional<reader::Region> region_in_words(const std::string& text, const reader::Asked& asked);
  bool is_vector(const Vec3& v, const char* what, const reader::Asked& asked);
  void add_fault(std::string key, std::string expected, std::string found) {
    faults_.add(0, std::move(key), std::move(expected), std::move(found));
  }

  void add_if_out_of_range(const std::string& table, const std::string& key, double value) {
    if (const auto wanted = wanted_in_range(table, key, value))
      add_fault(table + "." + key, *wanted, fmt::format("{}", value));
  }

  /// Adds faults of a scene file reader, without their file and line.
  void take(const std::vector<Fault>& faults) {
    for (const Fault& fault : faults)
      add_fault(fault.key, fault.expected, fault.found);
  }

  const SceneBuilder& asked_;
  FaultList faults_;
  reader::MaterialTable materials_;
  Scene scene_;
  Grid whole_;            ///< as given
  Index3 first_{0, 0, 0}; ///< position of the body's cell 0 in it
  bool has_body_ = false;
};

/// `(1, 2, 3)`
inline std::string in_words(const Vec3& v) {
  return fmt::format("({}, {}, {})", v[0], v[1], v[2]);
}

} // namespace maille
