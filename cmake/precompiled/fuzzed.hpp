/// The headers of library.hpp for what the fuzzers watch: the compiler wants the same flags.
#include "library.hpp"
