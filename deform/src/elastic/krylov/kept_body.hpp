#pragma once
/// What is kept of a body from one answer of `coupled` to the next.

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
  /// The constants of materials are others: what depends on them at the finest level becomes theirs, coarser
  /// ones may stay as they were. @param ratio by which matter became stiffer or softer, at most
  /// @return false where it is better made anew
  virtual bool take_materials(double ratio) = 0;
};

/// Answers to questions about one body, of which the start of the next is made. A linear body's answer is
/// linear in what is prescribed and in loads: the mean of earlier answers, weighted by least squares, whose
/// prescribed values and loads come nearest to the new ones. Moves that go on as they went begin where they
/// end. At finite strain an answer is a smooth function of its data along a course of questions.
class EarlierAnswers {
public:
  /// @return false, and `u` is not changed, where there is nothing to begin with
  bool find_start(const Scene& scene, const std::vector<Prescribed>& prescribed, Displacement& u);
  /// The start at finite strain: the polynomial through the answers and rest, along the way from the last
  /// data to the new ones, or the last answer, whichever data come nearer; straight lines, which double a
  /// bend, are none. What is prescribed is not in place.
  /// @return whether its data are the new ones but for rounding, or what a course curves; nothing, and `u` is
  ///         not changed, where there is no answer
  std::optional<bool> find_course(const Scene& scene, const std::vector<Prescribed>& prescribed,
                                  Displacement& u);
  /// Takes up an answer to the question of the last find_start().
  void add(const Scene& scene, const Displacement& u);
  /// The body's matter is another from now on: the last answer is a start, but no part of others.
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
  bool was_spanned_ = false;   ///< by them, the last question
  bool are_of_before_ = false; ///< before matter changed
};

/// A link's multiplier: the force with which its limits pull at its ends, over its weight in the
/// componentwise model [m].
struct KeptMultiplier {
  int component = 0, axis = 0;
  std::int64_t node = 0;
  double pull = 0;
};

/// One body: a copy of its matter, to which hierarchies refer, and what stands in memory for it.
class KeptBody {
public:
  KeptBody(const Scene& scene, int threads);

  /// With nothing prescribed and no loads, but for springs.
  const Scene& scene() const { return scene_; }
  ThreadTeam& team() { return team_; }
  /// True if a question is about this body: the same cells and tissue shares, rotation, springs, and
  /// materials of the same symmetry in the same places. The materials' constants may differ.
  bool is_of(const Scene& question) const;
  /// Takes over the constants of materials, and updates what depends on them.
  /// @return how many times stiffer or softer matter became, at most: 1 where nothing changed
  double take_materials(const Scene& question);

  std::unique_ptr<KeptHierarchy> hierarchy; ///< null: none yet
  EarlierAnswers answers;
  List<KeptMultiplier> multipliers; ///< of the last answer
  bool is_for_holds = false;        ///< hierarchies are made for what is held, whatever else is prescribed
  bool begins_anew = false;         ///< answers from rest, though the hierarchy is kept

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
