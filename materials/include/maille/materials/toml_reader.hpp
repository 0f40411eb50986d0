#pragma once
/// Reading TOML tables so that every error is found, with its line: shared by the readers of tissues,
/// scenes, worlds and studies.
///
/// A TableReader gives one key at a time and remembers which keys were asked for. At its end every other key
/// of the table is an error, with the nearest known key as a suggestion. Numbers become SI units as they are
/// read.
///
/// scene/keys.toml declares every key of a scene file once: type, unit, range, words, default, and what a
/// fault expects. Getters that name a key alone read it by its declaration.

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
/// @throws InputError if the text is not TOML: the parser stops at the first fault of syntax. Also for keys
///         of more than 256 dots
toml::table parse_toml(std::string_view text, const std::string& file);

/// A table that a program has made: the keys of a scene file, or of a part of one.
struct KeyTable {
  toml::table keys;
};

/// What numbers without a unit are in, by the line `units = "mm, deg"` of a file: factors to SI.
struct FileUnits {
  std::optional<double> length, angle; ///< nothing: a length, or an angle, needs a unit of its own
};

/// Collects faults of one file while it is read, and holds what its numbers are in.
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

/// What the number ought to be, by the declaration of a key; nothing where it is finite and in its range.
std::optional<std::string> wanted_in_range(std::string_view table, std::string_view key, double value);

/// One TOML table being read. Each getter reports an error for a value of the wrong form and remembers the
/// key; `finish` reports the keys that were not read.
class TableReader {
public:
  /// @param path     dotted key path of the table for messages, "" for the root
  /// @param declared the table of scene/keys.toml that declares its keys; "" where none does
  TableReader(const toml::table& table, std::string path, FaultList& faults, std::string_view declared = {});

  bool has(std::string_view key) const { return table_->contains(key); }
  /// Marks the key as known and returns its node, or nullptr where it is absent.
  const toml::node* find(std::string_view key);
  /// The same, with a fault where it is absent: as its declaration has it, or `expected`.
  const toml::node* require(std::string_view key);
  const toml::node* require(std::string_view key, std::string_view expected);
  /// What `require` expects by the declaration.
  std::string missing(std::string_view key) const;

  /// By the declaration. Absent: its default, or nothing; a fault where it is required. Nothing and a fault
  /// for what has the wrong form or is out of range.
  std::optional<double> number(std::string_view key);
  std::optional<std::int64_t> whole(std::string_view key);
  /// The place of the word in the declaration.
  std::optional<int> word(std::string_view key);
  std::vector<std::string_view> words(std::string_view key) const;
  /// Three quantities; one stands for all three where the type is `ratios`.
  std::optional<std::array<double, 3>> three(std::string_view key);
  /// The table under `key`; a fault if it is something else.
  std::optional<TableReader> open(std::string_view key);
  /// Puts what is there and right into `into`, which else stays as it is. @return whether it did
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
  /// The dimension that is declared.
  Dimension dimension(std::string_view key) const;
  /// The table of scene/keys.toml that declares the keys of the tables under `key`.
  std::string_view declared_under(std::string_view key) const;

  /// Absent: nothing and no fault. Wrong form: nothing and a fault.
  std::optional<std::string> text(std::string_view key);
  std::optional<double> quantity(std::string_view key, Dimension dimension);
  std::optional<std::int64_t> integer(std::string_view key, std::int64_t least, std::int64_t most);
  /// One of `choices`; of the declaration where there are none.
  std::optional<std::string> choice(std::string_view key, std::vector<std::string_view> choices = {});
  /// Three quantities, or one for all three where `one_for_all`.
  std::optional<std::array<double, 3>> quantities(std::string_view key, Dimension dimension,
                                                  bool one_for_all);
  /// A table under `key`; a fault if it is something else.
  const toml::table* subtable(std::string_view key);

  /// Reports keys that were never asked for.
  void finish();
  /// Adds a fault of `key`, on its line; the table's own where the key is absent or "".
  void fault(std::string_view key, std::string expected, std::string found);
  /// The same, with what stands there.
  void fault(std::string_view key, std::string expected);
  /// A fault if the key is there, where it has no place.
  void refuse(std::string_view key, std::string expected);

  const std::string& path() const { return path_; }
  std::string path_of(std::string_view key) const;
  int line() const;
  /// Line of a key; the table's own where it is absent.
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
/// What stands there, for messages: `"2 mm"`, `[1, 2]`, `a table`.
std::string describe(const toml::node& node);
/// A number or a string with a unit; nothing and a fault otherwise.
std::optional<double> read_quantity(const toml::node& node, const std::string& path, Dimension dimension,
                                    FaultList& faults);

/// Elastic constants from a table in one of the three forms of a scene file (isotropic: youngs_modulus,
/// poisson_ratio; orthotropic: E, nu, G; transversely isotropic: E_fibre, E_cross, G_fibre, nu_fibre,
/// nu_cross), checked for positive strain energy; every violated inequality is a fault, and so are the
/// incompressible limit, keys of two forms and a form that is not whole. Asks for no other key.
std::optional<ElasticConstants> read_elastic_constants(TableReader& table);

/// Elastic constants, or a `law` of large strain: neo_hookean with E and nu, others with a table
/// `parameters`. A law also sets the elasticity, to its own at rest.
/// @return false, and faults, where any is faulty
bool read_mechanics(TableReader& table, Material& material);

/// `units = "mm"`, `"mm, deg"`: what lengths and angles without a unit are in, put where every read_quantity
/// of the file sees it.
void read_units(TableReader& root);

/// Neighbour limits from keys stretch, compress (one ratio or three) and shear (one ratio, or a 3 x 3 table
/// [link axis][component]); nothing where none of the three is there. One that is absent leaves no play.
std::optional<NeighbourLimits> read_neighbour_limits(TableReader& table);

/// Damage from keys stretch (one ratio > 1, of all axes, or three), which has to be there, compress and shear
/// as of limits, of, source and verified, which need not. Nothing and faults where any is faulty.
std::optional<Damage> read_damage(TableReader& table);

} // namespace maille
