#pragma once
/// Errors in an input: all errors of a file at once, with positions, and suggestions for unknown words.
///
/// A reader collects Faults and throws one InputError at its end. One cause makes one Fault. `expected` and
/// `found` are phrases that end the sentence `FILE:LINE: KEY: expected ..., found ...`.

#include <cstddef>
#include <exception>
#include <string>
#include <string_view>
#include <vector>

namespace maille {

/// One error in an input file.
struct Fault {
  std::string file;     ///< as the user wrote it; empty without a file
  int line = 0;         ///< 1-based; 0 where no line applies
  std::string key;      ///< dotted key path, e.g. `specimen.spacing`; may be empty
  std::string expected; ///< the valid input
  std::string found;    ///< the actual input
};

/// One line for people: `scene.toml:12: specimen.spacing: expected a length > 0, found "-1 mm"`.
std::string to_string(const Fault& fault);

/// Thrown by readers only: all faults of one input.
class InputError : public std::exception {
public:
  explicit InputError(std::vector<Fault> faults);
  const std::vector<Fault>& faults() const { return faults_; }
  /// The faults, one a line.
  const char* what() const noexcept override { return text_.c_str(); }

private:
  std::vector<Fault> faults_;
  std::string text_;
};

/// Number of insertions, deletions, changes and swaps of neighbours that turn `a` into `b`, ignoring case:
/// the "optimal string alignment" distance. Cost: O(a.size() b.size()).
std::size_t spelling_distance(std::string_view a, std::string_view b);

/// True if `distance` edits to a word of `length` letters are likely a misspelling, not another word.
bool is_slip(std::size_t distance, std::size_t length);

/// The candidate nearest to `word`; empty if none is near enough for a misspelling.
std::string_view nearest_spelling(std::string_view word, const std::vector<std::string_view>& candidates);

} // namespace maille
