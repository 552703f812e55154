#pragma once

#include <string>

#include "tools/spacar/model.hpp"

namespace stillframe::tools::spacar {

/// The scene file of a model, with a comment on each entry that says from which line it came.
/// Remarks that come up while it is written are added to those of the model.
std::string scene_text(Model& model);

}  // namespace stillframe::tools::spacar
