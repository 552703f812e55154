#pragma once

#include <string>
#include <vector>

#include "tools/spacar/model.hpp"

namespace stillframe::tools::spacar {

/// The model of a SPACAR input file (.dat). Errors: InputError "FILE:LINE: KEYWORD: found ...,
/// allowed ..." of what cannot be read; what is read and has no place in a scene is a remark.
Model model_of_dat(const std::vector<std::string>& lines, const std::string& name);

}  // namespace stillframe::tools::spacar
