#pragma once
/// Which neighbour limits, or weights of `relaxed`, of one material or several come nearest to a reference
/// over a family of scenes; and what `maille fit` says of it.

#include "maille/scene/answer.hpp"

#include <nlohmann/json_fwd.hpp>

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace maille::studies {

/// One scene of a family and what is aimed at there.
struct FitCase {
  Scene scene;
  Displacement reference;
};

/// How far a method is from the reference on one scene: norms over the nodes that are neither held nor moved,
/// relative to the reference's whole displacement, so that squares of components add up to that of the whole.
struct FitError {
  Status status = Status::done;
  double relative_l2 = 0; ///< as in ErrorNorms
  Vec3 component{};       ///< share of each component
  double cut = 0;         ///< the largest part of a move that the limits cut back, over the largest move
};

/// The materials of a family: every one that a case has, once, known by its name, in the order of the cases.
/// @throws std::runtime_error where two of one name have different constants
std::vector<Material> materials_of(std::span<const FitCase> cases);

/// What `materials` make of the scene. Limits and weights are theirs, whatever the scene says.
/// @pre method is limits or relaxed
/// @throws std::runtime_error where the scene has one whose name is not among them, or the method refuses it
FitError fit_error(const FitCase& one, std::span<const Material> materials, std::string_view method,
                   const Control& control = {});

/// No limits and no weights can do better than this on the scene, by component (in units of FitError). In
/// both methods a component for itself stays between the least and the greatest value that is prescribed for
/// it, rest included: `limits` clamps rest by sums from there, `relaxed` is a mean of neighbours. What the
/// reference does beyond (what is squeezed out sideways, above all) is lost. 0 for a component that loads
/// pull and where the body turns as a whole.
Vec3 unreachable(const FitCase& one);

struct FitSettings {
  std::string method = "limits"; ///< or relaxed
  int evaluations = 20000;       ///< of the whole family, at most; the searches for single scenes not counted
};

/// One fitted number.
struct FittedNumber {
  std::string material;
  std::string name; ///< as in the file: stretch[x], shear[x][z], relaxed_weights[y]
  double value = 0;
  bool is_determined = false; ///< false: twice and half of its slack or weight change no answer of the family
  /// It stands at an end of the range that was searched: further would be better still, or as good
  bool is_at_end = false;
};

struct Fit {
  std::vector<Material> materials; ///< the family's, with the fitted limits or weights; in their own frames
  std::vector<FittedNumber> numbers;
  Status status = Status::done; ///< budget_reached or interrupted: the best so far
  int evaluations = 0;
  std::vector<FitError> fitted; ///< per case
  /// What each case comes to with limits found for it alone; empty where there is one case or the search was
  /// cut short
  std::vector<double> alone;
};

/// Finds the limits (`limits`: stretch, compress and shear of every axis) or the weights (`relaxed`:
/// relaxed_weights, no limit in the way) of all materials of the family with the least mean of squares of
/// relative_l2 over the cases, among those that let every move through whole.
///
/// Numbers that no answer depends on stay where the search starts: at taut limits for the largest of the
/// moves, at weights of 1. Every material's part of every component is searched for globally by controlled
/// random search with a fixed seed, then all numbers together by the subplex method; both from NLopt. So the
/// answer is good, not proven to be the best; see unreachable.
///
/// @pre  cases are not empty, and of one dimension; references are not zero everywhere
/// @throws std::runtime_error where the method refuses a scene, or no scene moves anything
/// Cost   some thousand answers of each scene
/// Repeatable  the same numbers to the bit
Fit fit(std::span<const FitCase> cases, const FitSettings& settings, const Control& control = {});

/// sqrt of the mean of squares of relative_l2.
double mean_error(std::span<const FitError> errors);

/// The material file: what a scene names by `material = "FILE.toml"`, or where there are several materials by
/// `"FILE.toml#NAME"`. Every number is written whole.
/// @param notes  lines of comment at its head
std::string material_file(const Fit& fit, const std::vector<std::string>& notes);

/// One scene's line.
struct FitRow {
  std::string scene;
  FitError error;
  std::optional<double>
      before; ///< with the limits and weights that the scene itself has; nothing where it has no answer
  std::optional<double> alone; ///< with limits found for this scene alone; only of fitted scenes
  Vec3 floor{};                ///< see unreachable
  std::optional<double>
      taut; ///< within taut limits at a scale of this scene's own; nothing where the method has no answer
  double least() const; ///< of all components
};

struct FitReport {
  std::string method, reference;
  Fit fit;
  std::vector<FitRow> fitted, held_out;
  std::vector<std::string> reasons; ///< why there is no better, in sentences
};

/// The row of a case, with what the scene itself would have come to.
FitRow fit_row(const FitCase& one, const FitError& error, std::optional<double> alone,
               const std::string& method, const Control& control);
/// Why the fit is no better: what nothing can reach, turned fibres, one set of limits for several moves.
std::vector<std::string> reasons_for(const FitReport& report, std::span<const FitCase> fitted);

/// sqrt of the mean of squares of the rows' errors.
double mean_error(std::span<const FitRow> rows);

/// For people.
std::string table(const FitReport& report);
nlohmann::ordered_json json(const FitReport& report);
/// Lines for the head of the material file.
std::vector<std::string> notes(const FitReport& report);

} // namespace maille::studies
