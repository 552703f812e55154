#pragma once

#include "core/mechanics/model/model.hpp"

namespace stillframe {

/// Checks that the partition of a model is sound in the scene as written: as many conditions as
/// dependent coordinates, and J = [D^(c)D^(0); D^(c)D^(m)] not singular. Errors: InputError at
/// `place` that names the free motion or the redundant conditions.
void check_partition(const Model& model, const std::string& place);

/// Throws that InputError for a partition known to be unsound.
[[noreturn]] void refuse_partition(const Model& model, const std::string& place);

}  // namespace stillframe
