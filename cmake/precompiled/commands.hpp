/// What most files of the command include.
#include "library.hpp"

#include <CLI/CLI.hpp>
