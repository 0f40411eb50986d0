#pragma once
/// The interface between a kind of body and everything that solves on it.
///
/// K is the body's stiffness, symmetric and positive definite on the free components. B is a preconditioner,
/// about K^-1: one multigrid cycle or a Cholesky factor. All fields are dense, [component][node], in float64.
///
/// Conjugate gradients (FlexibleGradients), limits (ConstrainedMinimum) and blocks (CorotatedRelaxation) use
/// these interfaces alone. A new kind of body is one class, and a case in elastic/ladder. Implemented by
/// BoxSystem, MaskedSystem, DirectSystem, BodySystem (1D, 2D and any body) and ComponentwiseSystem; TiedModel
/// decorates bodies by ties.

#include "elastic/krylov/conjugate_gradients.hpp"
#include "elastic/krylov/field_sums.hpp"
#include "elastic/model/fixed_mask.hpp"
#include "maille/scene/answer.hpp"

#include <cstdint>
#include <optional>
#include <utility>

namespace maille::deform {

class ElasticOperator {
public:
  virtual ~ElasticOperator() = default;
  /// forces = K u, at fixed components too [N].
  virtual void apply(const Displacement& u, Displacement& forces) = 0;
  /// correction = B residual [m]: symmetric and positive definite on free components and 0 on fixed ones, but
  /// for rounding to float32. At nodes without matter entries are 0 or keep their values.
  /// @pre residual is 0 at fixed components
  virtual void precondition(const Displacement& residual, Displacement& correction) = 0;
};

/// Adds stiffness / 2 (u_far - u_near)^2 of one component to the energy.
struct PenaltyLink {
  int component = 0, axis = 0;
  std::int64_t node = 0; ///< the near one
  double stiffness = 0;  ///< [N/m]

  bool operator==(const PenaltyLink&) const = default;
};

/// An operator that limits can use: B is about (K + penalties)^-1, where penalties are the stiffnesses of
/// active links.
class PenalizedOperator : public ElasticOperator {
public:
  /// Replaces the penalties.
  virtual void set_penalties(const List<PenaltyLink>& links) = 0;
};

/// The vectors of conjugate gradients around an ElasticOperator, in float64. Keeps the residual 0 at fixed
/// components.
class FieldGradients : public GradientSpace {
public:
  /// @param fixed of the fields' components
  FieldGradients(std::size_t n_components, FixedMask fixed, FieldSums sums)
      : residual_(n_components, fixed.n_nodes()), correction_(residual_), direction_(residual_),
        image_(residual_), sums_(std::move(sums)), fixed_(std::move(fixed)) {}

  /// Steps change `u` from now on. Both must outlive this.
  void begin(ElasticOperator& K, Displacement& u) {
    K_ = &K;
    u_ = &u;
    std::ranges::fill(direction_.values(), 0.0);
  }
  /// residual = forces - K u where components are free, 0 elsewhere. @param forces per component of the
  /// fields; empty: none @return u . K u
  template<class Forces>
  double find_residual(const Forces& forces);
  /// Work of the forces along the direction, per step.
  template<class Forces>
  double work_of(const Forces& forces) const;
  /// To be filled in by the caller.
  Displacement& residual() { return residual_; }
  double precondition() override;
  std::optional<double> find_step(double beta, double product) override;
  void take_step(double step) override;
  double overlap() const override { return overlap_; }

protected:
  Displacement residual_, correction_, direction_, image_;
  FieldSums sums_;
  FixedMask fixed_;
  ElasticOperator* K_ = nullptr;
  Displacement* u_ = nullptr;
  double curvature_ = 0; ///< p . K p [J]
  double overlap_ = 0;   ///< of the new residual with the correction for the one before [J]
};

template<class Forces>
double FieldGradients::find_residual(const Forces& forces) {
  const Displacement& u = *u_;
  K_->apply(u, image_);
  return sums_.sum([&](std::size_t first, std::size_t end) {
    double energy = 0;
    for (std::size_t b = 0; b < residual_.n_components(); ++b)
      for (std::size_t i = first; i < end; ++i) {
        energy += u(b, i) * image_(b, i);
        residual_(b, i) = fixed_(b, i) ? 0 : (forces[b].empty() ? 0 : forces[b][i]) - image_(b, i);
      }
    return energy;
  });
}

template<class Forces>
double FieldGradients::work_of(const Forces& forces) const {
  double sum = 0;
  for (std::size_t b = 0; b < forces.size(); ++b)
    for (std::size_t i = 0; i < forces[b].size(); ++i)
      sum += forces[b][i] * direction_(b, i);
  return sum;
}

inline double FieldGradients::precondition() {
  K_->precondition(residual_, correction_);
  return sums_.dot(residual_, correction_);
}

inline std::optional<double> FieldGradients::find_step(double beta, double) {
  sums_.add(1, correction_, beta, direction_);
  K_->apply(direction_, image_);
  curvature_ = sums_.dot(direction_, image_);
  if (!(curvature_ > 0))
    return std::nullopt;
  return sums_.dot(residual_, direction_) / curvature_;
}

/// State and residual after a step, and the term of Polak and Ribiere's rule, in one pass over memory.
inline void FieldGradients::take_step(double step) {
  Displacement& u = *u_;
  overlap_ = sums_.sum([&](std::size_t first, std::size_t end) {
    double overlap = 0;
    for (std::size_t b = 0; b < residual_.n_components(); ++b)
      for (std::size_t i = first; i < end; ++i) {
        u(b, i) += step * direction_(b, i);
        if (!fixed_(b, i))
          residual_(b, i) -= step * image_(b, i);
        overlap += residual_(b, i) * correction_(b, i);
      }
    return overlap;
  });
}

} // namespace maille::deform
