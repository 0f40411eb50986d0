#pragma once
/// The list of extremes, each with what is known about its answer.

#include "compare/methods.hpp"
#include "stability/stability.hpp"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace maille::lab {

/// A displacement that a method's answer to a scene must be, if any is known for that method.
using Truth = std::function<std::optional<Displacement>(const Scene& scene, std::string_view method)>;

/// One question that is asked of every method.
struct Extreme {
  std::string extreme, setting;
  std::function<Scene()> scene; ///< may throw InputError: then all methods are refused by the reader
  Truth truth = {};             ///< none: `limits` is compared with shortest paths, others with nothing
  bool is_normal = false;       ///< iterations of the extreme's other settings are compared with this one
  /// The truth is one that finite elements, linear in the grid's frame, do not know: their error is shown
  bool is_for_lattice = false;
  bool must_be_refused = false;          ///< an answer is a broken promise
  std::vector<std::string> methods = {}; ///< that are asked; empty: all of stability_methods()
  /// Where set, asked instead of solving the scene once. @param methods keeps what finite elements can keep
  std::function<StabilityCell(Methods& methods, const std::string& method, const Control& control)> protocol =
      {};
};

struct ExtremeSizes {
  int long_body = 100000;
  int drags = 10000;
  int cycles = 1000;
  int world_frames = 12;
  int objects = 500, free_bodies = 64; ///< of the largest worlds
};

/// All of them; those of one extreme follow one another, the normal setting first.
std::vector<Extreme> all_extremes(const ExtremeSizes& sizes);

void add_extremes_of_limits(std::vector<Extreme>& list);
void add_extremes_of_matter(std::vector<Extreme>& list);
void add_extremes_of_shape(std::vector<Extreme>& list, const ExtremeSizes& sizes);
void add_extremes_of_handles(std::vector<Extreme>& list);
void add_extremes_of_turns(std::vector<Extreme>& list);
void add_extremes_of_numbers(std::vector<Extreme>& list);
/// NaN and infinity in every numeric field of a scene, of its file and of a Scene that a program made.
void add_numbers_that_are_none(std::vector<Extreme>& list);
/// Worlds of turned, unlike, squeezed and rubbing objects.
void add_extremes_of_worlds(std::vector<Extreme>& list, const ExtremeSizes& sizes);
/// Worlds of many objects, and with dynamics.
void add_extremes_of_crowds(std::vector<Extreme>& list, const ExtremeSizes& sizes);
/// Drags in a row, and cycles.
void add_long_stories(std::vector<Extreme>& list, const ExtremeSizes& sizes);

/// Every method but CalculiX, which is not ours to promise for.
std::vector<std::string> stability_methods();

/// Fills the cell with the answer's status, broken promises and errors.
StabilityCell judged(const Extreme& extreme, const Scene& scene, const std::string& method,
                     const Answer& answer);

/// The largest Euclidean difference of a node over the largest length of the truth, all nodes alike; over the
/// body's length where the truth is nothing but rounding.
double largest_error(const Scene& scene, const Displacement& answer, const Displacement& truth);

} // namespace maille::lab
