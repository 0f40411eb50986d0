#pragma once
/// Limits of bodies whose nodes are tied: ConstrainedMinimum over a TiedModel, then projection.

#include "elastic/tied/tied_model.hpp"

#include <vector>

namespace maille::deform {

/// Changes u, in which tied nodes are together, to the least energy within limits (see ConstrainedMinimum)
/// and then to the nearest state that keeps them to the last bit, in which ties may be open by as much as the
/// answer's residual says. Adds to iterations, and says in the answer's message where borders stay open.
/// @param loads    [component][node], empty: none [N]; @param stiffer see ConstrainedMinimum
/// @param knows_forces  reactions are wanted: those of the least energy
/// @return  whether every tie is closed to the scene's tolerance of the largest displacement
/// Checked by  tests/deform/elastic/tied/tied_limits_test.cpp
bool keep_within_limits(TiedModel& model, const Loads& loads, double stiffer, bool knows_forces,
                        Displacement& u, Answer& answer);

/// What holds every prescribed component. @param forces K u - loads, and what limits pull with; changed
std::vector<double> reactions_of_tied(const TiedModel& model, Displacement& forces);

/// field -= loads; empty: none.
void subtract_loads(const Loads& loads, Displacement& field);

} // namespace maille::deform
