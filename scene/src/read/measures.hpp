#pragma once
/// The readers of [[measure]] tables.

#include "maille/scene/measure/measure.hpp"
#include "read/reader.hpp"

#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace maille::reader {

/// The `[[measure]]` tables of `root`, read after the body and its conditions. Without a body only their
/// faults are found.
std::vector<Measure> read_measures(TableReader& root, const Scene& scene, bool has_body);

/// Reads the places of measures in one scene.
class MeasurePlaces {
public:
  /// @param has_body  false: faults are found, but no places
  /// @param frame     frame of all places and of the normals of sections
  MeasurePlaces(const Scene& scene, bool has_body, TableFrame frame)
      : scene_(scene), has_body_(has_body), frame_(std::move(frame)) {}

  /// A point in the object's frame: one quantity per axis of the scene, or three; nothing and a fault for
  /// other values.
  std::optional<Vec3> place(const toml::node& node, const std::string& path, FaultList& faults) const;
  /// A list of points of valid length; empty and a fault otherwise.
  std::vector<Vec3> places(const toml::node& node, const std::string& path, std::size_t least,
                           std::size_t most, FaultList& faults) const;
  /// The same as points of the matter; a fault for each that is outside.
  std::vector<MaterialPoint> points(const toml::node& node, const std::string& path, std::size_t least,
                                    std::size_t most, FaultList& faults) const;
  /// `at`, `along` or `mean` of a table.
  void read_target(TableReader& table, Measure& measure) const;
  /// `"body"`, or a table of one of `label`, `material`, `where`, `sphere`.
  /// @param takes_nodes  true: a region without a whole cell gives its nodes
  void read_cells(const toml::node& node, const std::string& path, bool takes_nodes, Measure& measure,
                  FaultList& faults) const;
  /// `point` and `normal` of a plane through the body.
  void read_section(TableReader& table, Measure& measure) const;
  /// A normalised direction in the frame of the table; nothing and a fault for other values.
  std::optional<Vec3> direction(const toml::node& node, const std::string& path, FaultList& faults) const;

private:
  void read_line(TableReader& table, Measure& measure) const;
  void read_sphere(TableReader& table, Measure& measure) const;
  template<class Counts>
  void take_cells(Measure& measure, Counts&& counts) const;
  std::string reach() const;

  const Scene& scene_;
  bool has_body_;
  TableFrame frame_;
};

} // namespace maille::reader
