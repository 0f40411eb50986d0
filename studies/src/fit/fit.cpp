#include "fit/search.hpp"

#include <algorithm>
#include <cmath>

namespace maille::studies {

namespace {

/// Below this part of the error, two errors are the same.
constexpr double same_error = 1e-9;

/// True if twice or half of a number changes any answer that counts.
bool decides(FitSearch& search, const FitParameters& parameters, const std::vector<double>& best,
             double value, std::size_t i) {
  for (const double step : {std::log(0.5), std::log(2.0)}) {
    std::vector<double> x = best;
    x[i] = std::min(x[i] + step, std::max(parameters.high()[i], best[i]));
    if (std::abs(search.evaluate(x) - value) > same_error * value)
      return true;
  }
  return false;
}

/// True if a number stands where the search could not go on.
bool is_at_end(const FitParameters& parameters, const std::vector<double>& best, std::size_t i) {
  constexpr double near = 1e-3; // of its logarithm
  return best[i] - parameters.low()[i] < near || parameters.high()[i] - best[i] < near;
}

/// Changes each number that no answer depends on, by `changed(number, its place)`.
template<class Changed>
std::vector<double> with_idle_numbers(FitSearch& search, std::vector<double> best, double value,
                                      Changed changed) {
  for (std::size_t i = 0; i < best.size(); ++i) {
    std::vector<double> x = best;
    x[i] = changed(x[i], i);
    if (std::abs(search.evaluate(x) - value) <= same_error * value)
      best = x;
  }
  return best;
}

/// What every case comes to by itself, from where the family has come to.
std::vector<double> errors_alone(std::span<const FitCase> cases, const FitParameters& parameters,
                                 const FitSettings& settings, const std::vector<double>& start,
                                 const Control& control) {
  std::vector<double> errors;
  for (const FitCase& one : cases) {
    FitSearch search(std::span(&one, 1), parameters, settings.method, control);
    search.run(start, settings.evaluations);
    if (search.status() == Status::interrupted)
      return {};
    errors.push_back(std::sqrt(search.best_value()));
  }
  return errors;
}

} // namespace

Fit fit(std::span<const FitCase> cases, const FitSettings& settings, const Control& control) {
  const FitParameters parameters(cases, settings.method);
  FitSearch search(cases, parameters, settings.method, control);
  search.run(parameters.start(), settings.evaluations);
  Fit result;
  result.status = search.status();
  if (search.status() == Status::done && !search.is_feasible())
    result.status = Status::clamped;
  result.evaluations = search.evaluations();
  const double value = search.best_value();
  std::vector<double> best = search.best();
  if (result.status != Status::interrupted) // what the scenes do not say is left as it was
    best =
        with_idle_numbers(search, best, value, [&](double, std::size_t i) { return parameters.start()[i]; });
  // A link that nothing asks about must not bind where another scene pulls at it.
  if (settings.method == "limits" && result.status != Status::interrupted)
    best = with_idle_numbers(search, best, value, [](double x, std::size_t) {
      constexpr double open = 0; // the logarithm of a slack as long as the link, see limits_out_of_the_way
      return std::max(x, open);
    });
  result.materials = parameters.materials(best);
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const bool is_determined =
        result.status == Status::interrupted || decides(search, parameters, best, value, i);
    result.numbers.push_back({parameters.material_name(i), parameters.name(i), parameters.value(i, best),
                              is_determined, is_determined && is_at_end(parameters, best, i)});
  }
  Control without_stop; // one more answer a scene, also after an interrupt
  without_stop.threads = control.threads;
  for (const FitCase& one : cases)
    result.fitted.push_back(fit_error(one, result.materials, settings.method, without_stop));
  if (cases.size() > 1 && result.status != Status::interrupted)
    result.alone = errors_alone(cases, parameters, settings, best, control);
  return result;
}

} // namespace maille::studies
