#pragma once

#include <cstdint>

#include "core/mechanics/scene/scene.hpp"

namespace stillframe {

/// Adds an element to the scene as n equal parts in a row. Parts "b/1" to "b/n" and the nodes
/// "b/1" to "b/n-1" between them stand on the line from p to q: x_i = x_p + (x_q - x_p) i / n.
/// Everything else is the same for each part. With n = 1 the element is added as it is.
void add_divided(const SceneElement& element, std::int64_t n, Scene& scene);

}  // namespace stillframe
