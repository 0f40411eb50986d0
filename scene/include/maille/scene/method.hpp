#pragma once
/// The ways to answer a scene, as an enumeration beside their names.

#include <array>
#include <optional>
#include <string_view>

namespace maille {

/// In the order of every list of methods. Those up to `coupled` are deform's, the others come with fem_ref
/// and studies.
enum class Method {
  limits,   ///< neighbour limits alone: the least movement, by the cheapest way
  dijkstra, ///< the same by shortest paths: its oracle
  literal,  ///< Gibson's propagation of 1997, as published
  sweep,    ///< the relaxation of 1995, node by node
  relaxed,  ///< the same model with the material's weights, by multigrid
  coupled,  ///< full anisotropic elasticity on the lattice
  fem_q1,   ///< linear finite elements (deal.II)
  fem_q2,   ///< quadratic finite elements (deal.II)
  calculix, ///< the program CalculiX, where it is installed
};

inline constexpr std::array<Method, 9> every_method{Method::limits, Method::dijkstra, Method::literal,
                                                    Method::sweep,  Method::relaxed,  Method::coupled,
                                                    Method::fem_q1, Method::fem_q2,   Method::calculix};

/// `limits`, `fem_q1`, ... as on the command line and in Answer::method.
/// @param method one of every_method
std::string_view to_string(Method method);
/// The method of that name, to the letter; nothing where there is none.
std::optional<Method> method_from_string(std::string_view name);
/// False of methods that obey limits or relax by the rule of 1995: what they call displacement is in balance
/// with no stress.
bool has_stress(std::string_view method);

} // namespace maille
