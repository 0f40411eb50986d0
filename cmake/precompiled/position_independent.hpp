/// The headers of library.hpp for what shared objects are linked from: the compiler wants the same flags.
#include "library.hpp"
