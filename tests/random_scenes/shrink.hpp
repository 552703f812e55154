#pragma once

#include <functional>
#include <string>

namespace stillframe::random_scenes {

/// A smaller scene that still fails: parts of the YAML text (blocks, nodes and elements with all
/// that names them, list entries, keys) are taken out as long as `fails` says so of the rest, for
/// at most so long (s).
std::string shrink(std::string text, const std::function<bool(const std::string&)>& fails,
                   double longest_s = 20);

}  // namespace stillframe::random_scenes
