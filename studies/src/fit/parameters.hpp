#pragma once
/// The numbers that a fit looks for, as logarithms: slack and weights are positive, and matter by their
/// ratio.

#include "fit/fit.hpp"

namespace maille::studies {

class FitParameters {
public:
  /// Starts at taut limits, at the one scale at which every move of the family comes through, or at weights
  /// of 1.
  /// @throws std::runtime_error where limits are asked for and nothing moves
  FitParameters(std::span<const FitCase> cases, const std::string& method);

  std::size_t size() const { return start_.size(); }
  const std::vector<double>& start() const { return start_; }
  const std::vector<double>& low() const { return low_; }
  const std::vector<double>& high() const { return high_; }
  /// The numbers that decide one component, or all of them where turned fibres mix them; only those that can
  /// matter.
  const std::vector<std::vector<std::size_t>>& blocks() const { return blocks_; }
  /// The same of one material after the other: few enough to be searched for from everywhere.
  const std::vector<std::vector<std::size_t>>& blocks_of_materials() const { return blocks_of_materials_; }
  std::vector<Material> materials(const std::vector<double>& x) const;
  std::string name(std::size_t i) const;
  const std::string& material_name(std::size_t i) const { return base_[parameters_[i].material].name; }
  /// As the file has it: a ratio to the rest length, or a weight.
  double value(std::size_t i, const std::vector<double>& x) const;

private:
  enum class Kind { stretch, compress, shear, weight };
  struct Parameter {
    Kind kind;
    std::size_t material, axis, component;
  };
  void add(const Parameter& parameter, double start);
  void add_limits(std::span<const FitCase> cases);
  void group(std::span<const FitCase> cases);

  std::vector<Material> base_;
  std::vector<Parameter> parameters_;
  std::vector<double> start_, low_, high_;
  std::vector<std::vector<std::size_t>> blocks_, blocks_of_materials_;
};

/// Limits that no small strain reaches, for methods that are to feel none: twice and none of the rest length,
/// shear by it.
NeighbourLimits limits_out_of_the_way();

/// True if the material's axes are those of the grid, in any order.
bool is_along_grid(const Scene& scene);

/// True if something is prescribed other than 0, or pulls, along the component.
bool is_driven(const Scene& scene, int component);

} // namespace maille::studies
