#pragma once
/// Constants of a model from what was measured: weighted least squares, with intervals of confidence and a
/// refusal where the data do not determine them.

#include "maille/materials/toml_reader.hpp"
#include "maille/scene/answer.hpp"
#include "maille/scene/measure/measure.hpp"

#include <toml++/toml.h>

#include <Eigen/Core>

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille::studies {

/// One measured number. Measured columns are those of `[[measure]]` tables: NAME, of vectors NAME_x ...
struct Observation {
  std::string column;
  double value = 0;            ///< SI
  std::optional<double> sigma; ///< standard deviation, > 0, SI
  int line = 0;                ///< of the file
};

/// Reads CSV with the columns `measure`, `value` and, if wanted, `sigma`: numbers in SI, or with a unit.
/// @param units  of the columns that there are: `N`, `m`, ...
/// @throws InputError with every fault: unknown measures (the known ones are named), numbers that are none,
///         a sigma that is not > 0, one line with a sigma and another without, a measure twice
std::vector<Observation> read_observations(std::string_view text, const std::filesystem::path& file,
                                           const std::vector<std::pair<std::string, std::string>>& units);

/// An unknown, > 0; it is sought by its logarithm.
struct Unknown {
  std::string name;
  double start = 0;
};

enum class IdentifyStatus {
  done,
  undetermined,   ///< the data do not say what some unknown is
  budget_reached, ///< solves ran out before the steps got small
  interrupted,
  failed, ///< no answer at the start
};
std::string_view to_string(IdentifyStatus status);

struct Identified {
  std::string name;
  double value = 0;
  /// 95 %; unset where nothing tells how exact the data are.
  std::optional<std::pair<double, double>> interval;
  bool is_determined = true;
};

struct Identification {
  IdentifyStatus status = IdentifyStatus::done;
  std::string message;              ///< why it is not done
  std::vector<Identified> unknowns; ///< in the order that was asked
  std::vector<double> computed;     ///< a number an observation, at the end
  double misfit = 0;                ///< sum of squared residuals over their sigmas
  int freedom = 0;                  ///< observations less unknowns
  bool sigma_is_known = false;      ///< else it is a part of each value, found from the misfit
  int solves = 0;
};

struct IdentifySettings {
  double tolerance = 1e-4;     ///< of the last relative step of every unknown
  int solves_per_unknown = 12; ///< a budget: steps end with it
};

/// What the model says of every observation for values of the unknowns; nothing where it has no answer there.
using Model = std::function<std::optional<std::vector<double>>(const std::vector<double>& values)>;

/// Gauss and Newton's steps in logarithms, forward differences, halved where the misfit would grow; while the
/// model is far off, on logarithms of the data too, in which stiffness is nearly linear. Intervals come from
/// the linearised model: normal where sigmas are given, Student's where they are found from the misfit.
/// A combination of unknowns whose interval spans more than a factor of 100 is undetermined.
/// @param observations at least as many as unknowns
/// Cost: as many solves as unknowns and one more, a step. Source: Nocedal and Wright 2006, chapter 10; Seber
/// and Wild 1989, section 5.1
Identification identify(const std::vector<Unknown>& unknowns, const std::vector<Observation>& observations,
                        const Model& model, const IdentifySettings& settings = {},
                        const Control& control = {});

/// Measured displacements: of points in a table, or of every voxel of an image.
struct DisplacementData {
  std::vector<Measure> measures;         ///< a point each, of the scene as it was read
  std::vector<Observation> observations; ///< their columns, components in the world's frame
};

/// By its first row: columns `x`, `ux`, ... in place of `measure`.
bool is_table_of_points(std::string_view text);

/// Places and vectors are in the world of the body's image (of other bodies, the object's frame); those of an
/// image are taken from where its header says, values in mm.
/// @param sigma standard deviation of every component [m]; unset: of points the column `sigma`
/// @throws InputError with every fault: points without matter, no sigma, numbers that are none, no overlap
DisplacementData read_displacement_data(const std::filesystem::path& file, std::optional<double> sigma,
                                        const Scene& scene);

/// A constant of all matter of a name.
struct MaterialConstant {
  std::string constant,
      material; ///< `E_fibre`, `muscle/soleus`; no material: `constant` is a key of the scene
};

/// `E_fibre`, `E_cross of muscle/soleus` and keys of a scene, in any order: what stands before an `of` and
/// has no material of its own is of that one.
/// @param words  a list that was separated by commas
std::vector<MaterialConstant> constants_in(const std::vector<std::string>& words);

/// The tables of a scene that hold the constants of a material: [specimen] `material` and `labels` whose text
/// is its name, or whose table has it as `name`. A name of the library becomes a table of its constants, its
/// density and its limits, which say the same.
/// @param document  of the scene; changed where a name becomes a table
/// @return none where no matter has that name
/// @throws std::invalid_argument  matter of that name has no such constant
std::vector<toml::table*> tables_of(toml::table& document, const MaterialConstant& wanted);

} // namespace maille::studies
