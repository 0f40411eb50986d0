#pragma once
/// The kit, by its former name.

#include "support/kit.hpp"
