#pragma once
/// The cheapest way to answer a scene within an error and a time, before it is answered.
///
/// Two parts make a prediction. *Probes* answer the scene on lattices of twice and of four times its spacing,
/// which costs a fraction of an answer; their differences and times, scaled to other lattices by simple
/// rules, are the *raw* predictions. A *table* of trades measured on other scenes says how far measured
/// values lie from raw ones, as ratios: their median corrects, their quantiles are the uncertainty (split
/// conformal prediction: Papadopoulos and others 2002; Lei and others 2018, section 2.2, on the logarithm).
/// The promise is the upper quantile: it holds as often as it says for scenes drawn as those of the table
/// were, and for others as often as is measured by `studies/lab/run studies`.
///
/// A scene that is unlike those of the table in kind is not promised by it: there three lattices on which the
/// body is still itself have to approach each other, and their observed order with a margin is the promise;
/// where they do not, none is made. So it is with errors of force, energy and stress, of which the table
/// holds none: of `coupled`, three lattices speak for them.

#include "trade/probes.hpp"
#include "trade/quantity.hpp"

#include <map>
#include <span>

namespace maille::studies {

/// One measured row of a stored trade and what was predicted for it.
struct StoredRow {
  Way way; ///< as if the probes had been on lattices of twice and four times the spacing: finer ones shift it
  double error = 0, predicted_error = 0, seconds = 0, predicted_seconds = 0;
  std::string scene{}; ///< name and nodes: of one scene, a way and a prediction, one row counts
};

/// Reads tables that csv(Trade) wrote. Rows without measurement or prediction are passed over, and those
/// whose reference does not know its own error (only `best` does, where it could afford two meshes); an error
/// below that counts as that.
/// @throws InputError  no such file, columns missing, what is no number: with line
std::vector<StoredRow> read_trade_table(const std::filesystem::path& file);
/// The same from text; `name` for messages.
std::vector<StoredRow> parse_trade_table(std::string_view text, const std::string& name);
/// The table that stands in the sources, studies/trade/table.csv; compiled in.
std::vector<StoredRow> built_in_trade_table();
/// Its text, studies/trade/table.csv, compiled in.
std::string_view table_csv();

/// A number with what it may turn out to be.
struct Expected {
  double median = 0, low = 0, high = 0;
};

/// The value that a fraction `level` of draws does not exceed: the ceil((n + 1) level)-th smallest of n;
/// infinite where n is too small to say. @pre sorted, 0 < level < 1
double upper_quantile(std::span<const double> sorted, double level);
/// The value that a fraction `level` of draws is not below: the mirror image, 0 where n is too small.
/// @pre sorted
double lower_quantile(std::span<const double> sorted, double level);

/// The fewest scenes of which a quantile says anything: 19 at a level of 95 %.
std::size_t fewest_scenes(double level);

/// Ratios of measured to raw values, by way. A row that stands there twice counts once.
class Calibration {
public:
  explicit Calibration(std::span<const StoredRow> rows);
  /// Every way that the table knows.
  std::vector<Way> ways() const;
  bool knows(const Way& way) const;
  /// Different scenes that the best known way was measured on.
  std::size_t n_scenes() const;
  /// @param level  how often the high end is to hold, and the low end
  /// @pre the table knows the way
  Expected error(const Way& way, double raw, double level) const;
  Expected seconds(const Way& way, double raw, double level) const;

private:
  struct Ratios {
    Way way;
    std::vector<double> error, seconds; ///< sorted
  };
  const Ratios& of(const Way& way) const;
  std::vector<Ratios> ratios_;
};

/// What is asked for.
struct Wish {
  double error = 0;                  ///< relative, of the displacement L2, > 0
  double seconds = 0;                ///< set-up and solve, > 0
  std::optional<std::int64_t> bytes; ///< none: what the machine has
  double level = 0.95;               ///< how often error, and time, are to be kept
  Quantity of{};                     ///< what the error is of
};

/// One way and what it is expected to come to on this scene.
struct Candidate {
  Way way;
  Index3 cells{};
  Vec3 spacing{};
  std::int64_t nodes = 0;
  Expected error, seconds;
  std::int64_t bytes = 0; ///< that it needs at most
  bool meets(const Wish& wish) const;
};

struct Choice {
  Wish wish;
  Probes probes;
  std::vector<Candidate> candidates; ///< cheapest first, by expected time
  std::optional<Candidate> chosen;   ///< the cheapest that meets the wish
  /// Where none does: the least error in the time and memory, and the least time to the error, if there are
  /// such
  std::optional<Candidate> most_exact_in_time, quickest_to_error;
  std::vector<std::string> left_out; ///< ways about which nothing is said, and why
  std::size_t scenes = 0;            ///< that the table holds, see Calibration::n_scenes
};

/// The cheapest candidate that meets the wish, or the nearest ones. @pre sorted by expected time
void pick(Choice& choice);

/// Probes the scene and looks through every way of the table.
/// Cost  that of the probes, and a walk through the scene's cells for every lattice
/// @param judge_kind see probe
Choice choose(Lattices& lattices, const Wish& wish, const Calibration& calibration, const Control& control,
              bool judge_kind = true);

/// For people.
std::string table(const Scene& scene, const Choice& choice);
nlohmann::ordered_json json(const Scene& scene, const Choice& choice);

} // namespace maille::studies
