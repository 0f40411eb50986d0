#pragma once
/// A study: base scenes, varied keys and their combination, read from a TOML file.

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace maille::studies {

/// One value of a parameter.
struct StudyValue {
  std::string toml; ///< value inserted into the scene: `"10 kPa"`, `0.3`, `["1 mm", 0, 0]`
  std::variant<double, std::string> shown; ///< value in tables: number in the parameter's unit, or text
  friend bool operator==(const StudyValue&, const StudyValue&) = default;
};

/// Range of a parameter, including both ends. For a normal distribution: mean and deviation; for a lognormal
/// one: median and the factor of one deviation.
struct StudyRange {
  double from = 0, to = 0; ///< in the parameter's unit
  bool is_logarithmic = false, is_normal = false;
};

/// A varied parameter: one or more keys of the scene with the same value.
struct StudyParameter {
  std::vector<std::string> keys; ///< dotted: `specimen.material.E_fibre`, `move[1].by`
  std::string label;             ///< default: first key
  std::string unit;              ///< unit of all values, as in the study; empty: SI numbers, or text
  std::optional<StudyRange> range;
  std::vector<StudyValue> values; ///< from a list, or a range with a count; empty for sampled ranges
  std::string formula; ///< formula of labels of earlier parameters, see value_of_formula; empty: none

  /// Column name: `label [unit]`.
  std::string column() const;
  /// Value at the fraction `u` of the range or list. @param u in [0, 1)
  StudyValue at(double u) const;
};

/// Combination of parameters to cases.
enum class Combination { grid, zip, latin_hypercube, sobol, saltelli };

/// Column of a scene measure: NAME, NAME_x, NAME_error ...
struct MeasureColumn {
  std::string name, unit; ///< empty: a ratio
  friend bool operator==(const MeasureColumn&, const MeasureColumn&) = default;
};

/// A base scene, complete and valid.
struct StudyScene {
  std::filesystem::path file;
  std::string text; ///< TOML
  std::string name() const { return file.stem().string(); }
};

struct StudyFile {
  std::filesystem::path file;
  std::string title;
  std::vector<StudyScene> scenes;
  std::vector<MeasureColumn> measures;    ///< of all scenes, without duplicates
  std::vector<StudyParameter> parameters; ///< without keys: only for formulas
  std::vector<StudyParameter> formulas;   ///< dependent parameters, evaluated per case
  Combination combination = Combination::grid;
  int samples = 0;        ///< points for latin_hypercube and sobol; pairs of points for saltelli
  std::uint64_t seed = 1; ///< for latin_hypercube
  std::vector<std::string> methods;
  std::string reference;         ///< a method, "best", or empty: no errors
  double reference_seconds = 60; ///< approximate time of the reference "best" per case
  int repetitions = 1;           ///< of every method except the reference; seconds are medians
  bool vtk_of_all = false;
  std::vector<int> vtk_cases; ///< case numbers; empty if vtk_of_all

  std::string name() const { return file.stem().string(); }
  bool wants_vtk(int number) const;
  /// Methods of a case's rows in order: `methods`, then the reference if it is not among them.
  std::vector<std::string> row_methods() const;
  /// Parameters, then formulas.
  std::size_t n_varied() const { return parameters.size() + formulas.size(); }
  const StudyParameter& varied(std::size_t i) const {
    return i < parameters.size() ? parameters[i] : formulas[i - parameters.size()];
  }
};

/// One case of the study.
struct StudyCase {
  int number = 0;                 ///< from 1
  std::size_t scene = 0;          ///< index into StudyFile::scenes
  std::vector<StudyValue> values; ///< one per parameter, then one per formula
};

/// Reads a study file and its base scenes, whose paths are relative to its folder.
/// @throws InputError with all errors of both (file, line, key): unknown keys, keys missing in a scene, mixed
///         units, ...
StudyFile read_study(const std::filesystem::path& file);
/// The same from text; `file` gives the name for messages and the folder for scenes.
StudyFile parse_study(std::string_view text, const std::filesystem::path& file);

/// All cases, numbered from 1: the same points for each scene. A grid's last parameter varies fastest.
/// Repeatable  the same numbers on every machine, random plans included
std::vector<StudyCase> cases(const StudyFile& study);

/// Number of cases, without creating them. @pre read without errors, which bounds it by a million
std::int64_t n_cases(const StudyFile& study);

/// Scene of a case as TOML: the base scene with the case's values. It may be invalid if values are.
std::string resolved_scene(const StudyFile& study, const StudyCase& one);

/// Identity of a row: SHA-256 of the scene with the case's values (keys sorted, title omitted), of the files
/// that it names (images with the data files of their headers), and of all other settings that affect its
/// results. Threads and jobs are excluded: results do not depend on them, to the bit.
class CaseHashes {
public:
  /// @param settings  in words: the solver
  CaseHashes(const StudyFile& study, std::string settings);
  /// 64 hexadecimal digits. Cost: each named file is read once, each case parsed once a call
  std::vector<std::string> of_case(const StudyCase& one, const std::vector<std::string>& methods);

private:
  std::string digest_of_file(const std::filesystem::path& file);
  /// Digests of files that are opened by reading the scene but not named in its texts, such as slices of a
  /// series.
  std::string digests_of_opened(const StudyCase& one, const std::vector<std::string>& texts);

  const StudyFile& study_;
  std::string settings_;
  std::map<std::filesystem::path, std::string> known_files_; ///< an empty digest marks a missing file
  std::map<std::string, std::string> known_opened_;          ///< by files and folders named in texts
};

} // namespace maille::studies
