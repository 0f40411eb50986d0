#pragma once
/// Reading TOML tables so that every error is found, with its line: shared by the readers of tissues,
/// scenes, worlds and studies.
///
/// A TableReader returns one key at a time and records which keys were read. finish() reports every other key
/// of the table as an error, with the nearest known key as a suggestion. Numbers are converted to SI units.
///
/// scene/keys.toml declares every key of a scene file once: type, unit, range, words, default, and the
/// expected value for faults. Getters with only a key argument use its declaration.

#include "maille/materials/fault.hpp"
#include "maille/materials/material.hpp"
#include "maille/materials/quantity.hpp"

#include <toml++/toml.h>

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace maille {

/// The root table of a TOML text.
/// @param file its name for messages
/// @throws InputError if the text is not TOML (the parser stops at the first syntax error), and for keys
///         with more than 256 dots
toml::table parse_toml(std::string_view text, const std::string& file);

/// A table made by a program: the keys of a scene file, or of a part of one.
struct KeyTable {
  toml::table keys;
};

/// Units of numbers without a unit, from the line `units = "mm, deg"` of a file: factors to SI.
struct FileUnits {
  std::optional<double> length, angle; ///< nothing: lengths, or angles, must have a unit
};

/// Collects the faults of one file while it is read, and stores its units.
class FaultList {
public:
  FileUnits units;

  explicit FaultList(std::string file) : file_(std::move(file)) {}
  void add(int line, std::string key, std::string expected, std::string found);
  bool empty() const { return faults_.empty(); }
  std::size_t size() const { return faults_.size(); }
  const std::string& file() const { return file_; }
  /// Sorted by line. @throws InputError if there is any fault
  void throw_if_any();

private:
  std::string file_;
  std::vector<Fault> faults_;
};

/// Expected value of a number by the declaration of its key; nothing if it is finite and in range.
std::optional<std::string> wanted_in_range(std::string_view table, std::string_view key, double value);

/// Reader of one TOML table. Each getter reports a fault for a value of the wrong form and records the key;
/// `finish` reports the keys that were not read.
class TableReader {
public:
  /// @param path     dotted key path of the table for messages, "" for the root
  /// @param declared the table of scene/keys.toml that declares its keys; "" without one
  TableReader(const toml::table& table, std::string path, FaultList& faults, std::string_view declared = {});

  bool has(std::string_view key) const { return table_->contains(key); }
  /// Marks the key as read and returns its node, or nullptr if it is absent.
  const toml::node* find(std::string_view key);
  /// The same, with a fault if it is absent: expecting its declaration, or `expected`.
  const toml::node* require(std::string_view key);
  const toml::node* require(std::string_view key, std::string_view expected);
  /// Expected value by the declaration, for faults of `require`.
  std::string missing(std::string_view key) const;

  /// Reads by the declaration. Absent: its default, or nothing; a fault if it is required. Wrong form or out
  /// of range: nothing and a fault.
  std::optional<double> number(std::string_view key);
  std::optional<std::int64_t> whole(std::string_view key);
  /// Index of the word in the declaration.
  std::optional<int> word(std::string_view key);
  std::vector<std::string_view> words(std::string_view key) const;
  /// Three quantities; a single one applies to all three if the type is `ratios`.
  std::optional<std::array<double, 3>> three(std::string_view key);
  /// The table under `key`; a fault if it is something else.
  std::optional<TableReader> open(std::string_view key);
  /// Stores a valid value in `into`; otherwise `into` is unchanged. @return true if it was stored
  bool read(std::string_view key, double& into);
  bool read(std::string_view key, std::int64_t& into);
  bool read(std::string_view key, int& into);
  bool read(std::string_view key, bool& into);
  bool read(std::string_view key, std::string& into);
  /// @pre words of the declaration are in the order of the enumeration
  template<class Enum>
  requires std::is_enum_v<Enum>
  bool read(std::string_view key, Enum& into) {
    const auto place = word(key);
    into = place ? static_cast<Enum>(*place) : into;
    return place.has_value();
  }
  /// Declared dimension of a key.
  Dimension dimension(std::string_view key) const;
  /// The table of scene/keys.toml that declares the keys of the tables under `key`.
  std::string_view declared_under(std::string_view key) const;

  /// Absent: nothing and no fault. Wrong form: nothing and a fault.
  std::optional<std::string> text(std::string_view key);
  std::optional<double> quantity(std::string_view key, Dimension dimension);
  std::optional<std::int64_t> integer(std::string_view key, std::int64_t least, std::int64_t most);
  /// One of `choices`; if empty, of the words in the declaration.
  std::optional<std::string> choice(std::string_view key, std::vector<std::string_view> choices = {});
  /// Three quantities, or one for all three if `one_for_all`.
  std::optional<std::array<double, 3>> quantities(std::string_view key, Dimension dimension,
                                                  bool one_for_all);
  /// A table under `key`; a fault if it is something else.
  const toml::table* subtable(std::string_view key);

  /// Reports keys that were not read.
  void finish();
  /// Adds a fault of `key`, at its line; at the table's if the key is absent or "".
  void fault(std::string_view key, std::string expected, std::string found);
  /// The same, with the actual value as found.
  void fault(std::string_view key, std::string expected);
  /// A fault if the key is present in a table that must not have it.
  void refuse(std::string_view key, std::string expected);

  const std::string& path() const { return path_; }
  std::string path_of(std::string_view key) const;
  int line() const;
  /// Line of a key; the table's if it is absent.
  int line_of_key(std::string_view key) const;
  FaultList& faults() { return *faults_; }

private:
  std::string_view said(std::string_view key, std::string_view what) const;
  bool is_in_range(std::string_view key, double value);
  bool is_missed(std::string_view key);

  const toml::table* table_;
  std::string path_;
  FaultList* faults_;
  std::string_view declared_;
  std::set<std::string, std::less<>> known_;
};

/// Line of a node, 1-based.
int line_of(const toml::node& node);
/// The value of a node for messages: `"2 mm"`, `[1, 2]`, `a table`.
std::string describe(const toml::node& node);
/// A number or a string with a unit; nothing and a fault otherwise.
std::optional<double> read_quantity(const toml::node& node, const std::string& path, Dimension dimension,
                                    FaultList& faults);

/// Elastic constants from a table in one of the three forms of a scene file (isotropic: youngs_modulus,
/// poisson_ratio; orthotropic: E, nu, G; transversely isotropic: E_fibre, E_cross, G_fibre, nu_fibre,
/// nu_cross), checked for positive strain energy. Faults: every violated inequality, the incompressible
/// limit, keys of two forms, an incomplete form. Reads no other key.
std::optional<ElasticConstants> read_elastic_constants(TableReader& table);

/// Elastic constants, or a `law` of large strain: neo_hookean with E and nu, others with a table
/// `parameters`. A law also sets the elasticity to its rest constants.
/// @return false, with faults, if any is invalid
bool read_mechanics(TableReader& table, Material& material);

/// Reads `units = "mm"`, `"mm, deg"`: the units of lengths and angles without a unit, for all calls of
/// read_quantity for the file.
void read_units(TableReader& root);

/// Neighbour limits from keys stretch, compress (one ratio or three) and shear (one ratio, or a 3 x 3 table
/// [link axis][component]); nothing if all are absent. An absent one allows no deformation.
std::optional<NeighbourLimits> read_neighbour_limits(TableReader& table);

/// Damage from keys stretch (one ratio > 1 for all axes, or three; required), compress and shear as in
/// limits, of, source and verified (all optional). Nothing and faults if any is invalid.
std::optional<Damage> read_damage(TableReader& table);

} // namespace maille
