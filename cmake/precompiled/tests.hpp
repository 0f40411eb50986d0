/// What most files of the tests include; compiled once (option MAILLE_PRECOMPILE). Files still
/// include what they use: they compile without it.
#include "library.hpp"

#include <gtest/gtest.h>
