#pragma once
/// A study: base scenes, the keys that vary and how they are combined, read from a TOML file.

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
  std::string toml; ///< what is put into the scene: `"10 kPa"`, `0.3`, `["1 mm", 0, 0]`
  std::variant<double, std::string> shown; ///< in tables: the number in the parameter's unit, or the text
  friend bool operator==(const StudyValue&, const StudyValue&) = default;
};

/// What a range runs over; both ends belong to it. A normal distribution has its mean and deviation there, a
/// lognormal one its median and the factor of one deviation.
struct StudyRange {
  double from = 0, to = 0; ///< in the parameter's unit
  bool is_logarithmic = false, is_normal = false;
};

/// One thing that varies: one or more keys of the scene that take the same value.
struct StudyParameter {
  std::vector<std::string> keys; ///< dotted: `specimen.material.E_fibre`, `move[1].by`
  std::string label;             ///< default: the first key
  std::string unit;              ///< of all its values, as the study writes it; empty: numbers in SI, or text
  std::optional<StudyRange> range;
  std::vector<StudyValue>
      values;          ///< of a list, and of a range with a count; empty where plans draw from a range
  std::string formula; ///< of labels of earlier parameters, see value_of_formula; empty: none

  /// The name of its column: `label [unit]`.
  std::string column() const;
  /// The value at a part of the way through the range, or of the list. @param u in [0, 1)
  StudyValue at(double u) const;
};

/// How parameters are combined into cases.
enum class Combination { grid, zip, latin_hypercube, sobol, saltelli };

/// A column of the measures of scenes: NAME, NAME_x, NAME_error ...
struct MeasureColumn {
  std::string name, unit; ///< empty: a ratio
  friend bool operator==(const MeasureColumn&, const MeasureColumn&) = default;
};

/// A base scene, whole and without fault.
struct StudyScene {
  std::filesystem::path file;
  std::string text; ///< TOML
  std::string name() const { return file.stem().string(); }
};

struct StudyFile {
  std::filesystem::path file;
  std::string title;
  std::vector<StudyScene> scenes;
  std::vector<MeasureColumn> measures;    ///< of any of the scenes, each once
  std::vector<StudyParameter> parameters; ///< without keys: for formulas alone
  std::vector<StudyParameter> formulas;   ///< what follows from parameters, case by case
  Combination combination = Combination::grid;
  int samples = 0;        ///< of latin_hypercube and sobol; of saltelli pairs of points
  std::uint64_t seed = 1; ///< of latin_hypercube
  std::vector<std::string> methods;
  std::string reference;         ///< a method, "best", or empty: no errors
  double reference_seconds = 60; ///< what the reference "best" may take a case, about
  int repetitions = 1;           ///< of every method but the reference; seconds are their medians
  bool vtk_of_all = false;
  std::vector<int> vtk_cases; ///< case numbers; empty where vtk_of_all

  std::string name() const { return file.stem().string(); }
  bool wants_vtk(int number) const;
  /// The methods of a case's rows in their order: methods, then the reference where it is not among them.
  std::vector<std::string> row_methods() const;
  /// Parameters, then formulas.
  std::size_t n_varied() const { return parameters.size() + formulas.size(); }
  const StudyParameter& varied(std::size_t i) const {
    return i < parameters.size() ? parameters[i] : formulas[i - parameters.size()];
  }
};

/// One point of the study.
struct StudyCase {
  int number = 0;                 ///< from 1
  std::size_t scene = 0;          ///< index into StudyFile::scenes
  std::vector<StudyValue> values; ///< one a parameter, then one a formula
};

/// Reads a study file and its base scenes, which are relative to its folder.
/// @throws InputError with every fault of both (file, line, key): unknown keys, keys that a scene lacks,
///         mixed units, ...
StudyFile read_study(const std::filesystem::path& file);
/// The same from text; `file` gives the name for messages and the folder for scenes.
StudyFile parse_study(std::string_view text, const std::filesystem::path& file);

/// Every case, numbered from 1: scene by scene the same points. A grid's last parameter varies fastest.
/// Repeatable  the same numbers everywhere, random plans too
std::vector<StudyCase> cases(const StudyFile& study);

/// How many cases there are, without making them. @pre read without fault, which bounds it by a million
std::int64_t n_cases(const StudyFile& study);

/// The scene of a case as TOML: the base scene with the case's values in place. It may be faulty where values
/// are.
std::string resolved_scene(const StudyFile& study, const StudyCase& one);

/// What a row is recognised by: SHA-256 of the scene with its values in place (keys sorted, title left out),
/// of the files that it names (images with the data that their headers name), and of everything else that its
/// results depend on. Threads and jobs are not among that: results are the same for any number of them, to
/// the bit.
class CaseHashes {
public:
  /// @param settings  in words: the solver
  CaseHashes(const StudyFile& study, std::string settings);
  /// 64 hexadecimal digits. Cost: each named file is read once, each case parsed once a call
  std::vector<std::string> of_case(const StudyCase& one, const std::vector<std::string>& methods);

private:
  std::string digest_of_file(const std::filesystem::path& file);
  /// Of files that reading the scene opens and that none of its texts names, such as slices of a series.
  std::string digests_of_opened(const StudyCase& one, const std::vector<std::string>& texts);

  const StudyFile& study_;
  std::string settings_;
  std::map<std::filesystem::path, std::string> known_files_; ///< empty digest: no file
  std::map<std::string, std::string> known_opened_;          ///< by the files and folders that texts name
};

} // namespace maille::studies
