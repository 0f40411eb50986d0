#pragma once
/// Work that was left behind because its caller asked to stop and a library would not.

namespace maille::fem_ref {

/// Threads that are still at such work: a factorisation, an analysis, a hierarchy of meshes. They end by
/// themselves as soon as the library gives way, and touch nothing that a caller owns. A program that ends
/// while there are any has to leave by std::_Exit, after its output is flushed: the objects that its
/// libraries would destroy are in use.
int works_left_behind();

} // namespace maille::fem_ref
