#pragma once
/// Cache of a body between answers of `coupled`: its hierarchy, earlier answers, and multipliers.
///
/// A question about the same cells, materials and springs reuses three things: the multigrid hierarchy, if
/// the fixed components are (almost) the same; earlier answers, combined into a start; and the multipliers of
/// active limits. Constants of materials may change by a factor that the hierarchy tolerates.
///
/// Exact: nothing of an answer depends on the cache beyond its tolerance. Heuristic: which start is near
/// enough.

#include "elastic/krylov/coupled_task.hpp"

#include <Eigen/Core>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace maille::deform {

/// Set-up that one solver of `coupled` caches for its own reuse.
class KeptHierarchy {
public:
  virtual ~KeptHierarchy() = default;
  /// Adapts the finest level to changed constants of materials; coarser levels may stay as they are. @param
  /// ratio largest change of stiffness, as a factor @return false if rebuilding is better
  virtual bool adopt_materials(double ratio) = 0;
};

/// Earlier answers about one body, which give the start of the next one. A linear body's answer is linear in
/// prescribed values and loads. So the start is the combination of earlier answers whose prescribed values
/// and loads come nearest to the new ones (least squares). A motion that continues along its course starts at
/// its result.
class EarlierAnswers {
public:
  /// @return false, and `u` is unchanged, if no earlier answer helps
  bool find_start(const Scene& scene, const std::vector<Prescribed>& prescribed, Displacement& u);
  /// The start at finite strain: the polynomial through the answers and rest, along the way from the last
  /// data to the new ones, or the last answer, whichever data come nearer; straight lines, which double a
  /// bend, are none. What is prescribed is not in place.
  /// @return whether its data are the new ones but for rounding, or what a course curves; nothing, and `u` is
  ///         not changed, where there is no answer
  std::optional<bool> find_course(const Scene& scene, const std::vector<Prescribed>& prescribed,
                                  Displacement& u);
  /// Adds the answer to the question of the last find_start().
  void add(const Scene& scene, const Displacement& u);
  /// Matter has changed: the last answer is still a start, but no part of a combination.
  void matter_has_changed();
  void forget() { answers_.clear(); }

private:
  using Loads = std::array<List<double>, 3>;
  struct One {
    Displacement u;
    Loads loads;
  };
  static constexpr std::size_t most = 3; ///< a node that is moved has three directions

  Eigen::MatrixXd products_with(const Scene& scene, const std::vector<Prescribed>& prescribed) const;
  Displacement mean(const Scene& scene, const Eigen::VectorXd& weights) const;

  std::vector<One> answers_;   ///< the newest last
  bool was_spanned_ = false;   ///< the last question was a combination of answers_
  bool are_of_before_ = false; ///< answers_ precede a change of matter
};

/// A link's multiplier: the force with which its limits pull at its ends, over its weight in the
/// componentwise model [m].
struct KeptMultiplier {
  int component = 0, axis = 0;
  std::int64_t node = 0;
  double pull = 0;
};

/// One body: a copy of its matter, to which hierarchies refer, and its cache.
class KeptBody {
public:
  KeptBody(const Scene& scene, int threads);

  /// With nothing prescribed and no loads, but for springs.
  const Scene& scene() const { return scene_; }
  ThreadTeam& team() { return team_; }
  /// True if a question is about this body: the same cells and tissue shares, rotation, springs, and
  /// materials of the same symmetry in the same places. The materials' constants may differ.
  bool is_of(const Scene& question) const;
  /// Adopts the constants of materials and updates the cache. @return largest change of stiffness, as a
  /// factor; 1: none
  double adopt_materials(const Scene& question);

  std::unique_ptr<KeptHierarchy> hierarchy; ///< null: none yet
  EarlierAnswers answers;
  List<KeptMultiplier> multipliers; ///< of the last answer
  bool is_for_holds = false;        ///< hierarchies fix holds only, not other prescribed components
  bool begins_anew = false;         ///< each answer starts at rest; the hierarchy is cached

private:
  Scene scene_;
  Charge of_scene_;
  ThreadTeam team_;
};

/// True if links were at their limits in the last answer: the next solve starts there, not from an elastic
/// answer.
inline bool begins_within_limits(const CoupledTask& task) {
  return task.limits != nullptr && task.kept != nullptr && !task.kept->begins_anew &&
         !task.kept->multipliers.empty();
}

} // namespace maille::deform
