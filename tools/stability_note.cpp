#include "tools/stability_note.hpp"

#include <iostream>

#include "tools/largest_parts.hpp"
#include "tools/node_parts.hpp"

namespace stillframe::tools {

Json warn_unless_stable(const Model& model, const LinearModel& linear) {
  const Stability found = stability(linear);
  if (!found.stable) return nullptr;
  if (!*found.stable) {
    std::cerr << "stillframe: warning: the operating point is not stable, and nothing stays there: "
              << found.why_not;
    if (found.shape.size() > 0 && found.shape.size() == model.n_d) {
      const NodeParts parts = node_parts(model, linear.x_0);
      std::cerr << ", which moves "
                << largest_parts(parts.names,
                                 parts.of_displacements *
                                     (displacements_of_dofs(model, linear.x_0) * found.shape))
                << " (m and rad over the largest)";
    }
    std::cerr << "\n";
  }
  return *found.stable;
}

}  // namespace stillframe::tools
