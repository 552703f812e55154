#pragma once

#include <string>
#include <vector>

#include "tools/spacar/model.hpp"

namespace stillframe::tools::spacar {

/// The model of a SPACAR Light script (.m); given: assignments before its first line. Errors:
/// InputError "FILE:LINE: FIELD: found ..., allowed
/// ..." of what cannot be read; what is read and has no place in a scene is a remark.
Model model_of_light(const std::vector<std::string>& lines, const std::string& name,
                     const std::vector<std::string>& given = {});

}  // namespace stillframe::tools::spacar
