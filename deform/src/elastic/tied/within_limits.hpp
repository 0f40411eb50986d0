#pragma once
/// The last step of every elastic method where nodes are tied and limits bind.

#include "elastic/tied/tied_links.hpp"
#include "elastic/tied/tied_model.hpp"
#include "maille/scene/arena.hpp"

#include <vector>

namespace maille::deform {

/// Changes u, in which tied nodes are together, to the least energy within limits (see LeastWithinLimits) and
/// then to the nearest state that keeps them to the last bit, in which ties may be open by as much as the
/// answer's residual says. Adds to iterations, and says in the answer's message where borders stay open.
/// @param links    whose weights are those of penalties; takes the limits of the model's task
/// @param loads    [component][node], empty: none [N]; @param penalty at first, beside the operator [1]
/// @param knows_forces  reactions are wanted: those of the least energy
/// @return  whether every tie is closed to the scene's tolerance of the largest displacement
bool keep_within_limits(TiedModel& model, TiedLinks& links, const std::vector<List<double>>& loads,
                        double penalty, bool knows_forces, Displacement& u, Answer& answer);

/// What holds every prescribed component. @param forces K u - loads, and what limits pull with; changed
std::vector<double> reactions_of_tied(const TiedModel& model, Displacement& forces);

} // namespace maille::deform
