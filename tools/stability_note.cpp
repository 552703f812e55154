#include "tools/stability_note.hpp"

#include <iostream>

#include "core/mechanics/operating_point.hpp"
#include "tools/largest_parts.hpp"
#include "tools/node_parts.hpp"

namespace stillframe::tools {

namespace {

/// displacements: n_x.
std::string in_words(const NodeParts& parts, const Eigen::VectorXd& displacements) {
  return largest_parts(parts.names, parts.of_displacements * displacements) +
         " (m and rad over the largest)";
}

void warn(const std::string& why_not, const std::string& moves) {
  std::cerr << "stillframe: warning: the operating point is not stable, and nothing stays there: "
            << why_not << (moves.empty() ? "" : ", which moves ") << moves << "\n";
}

}  // namespace

std::string what_moves(const Model& model, const LinearModel& linear,
                       const Eigen::VectorXd& shape) {
  return in_words(node_parts(model, linear.x_0), displacements_of_dofs(model, linear.x_0) * shape);
}

std::string what_moves(const Model& model, const Eigen::VectorXd& x, const Eigen::VectorXd& shape) {
  Eigen::VectorXd displacements = Eigen::VectorXd::Zero(model.n_x);
  displacements.head(shape.size()) = shape;
  return in_words(node_parts(model, x), displacements);
}

Json warn_unless_stable(const Model& model, const LinearModel& linear) {
  const Stability found = stability(linear);
  if (!found.stable) return nullptr;
  const bool known = found.shape.size() > 0 && found.shape.size() == model.n_d;
  if (!*found.stable) {
    warn(found.why_not, known ? what_moves(model, linear, found.shape) : "");
  }
  return *found.stable;
}

Json warn_unless_stable(const MixedModel& mixed, const MixedState& state,
                        const std::function<void()>& modes) {
  try {
    modes();
    return true;
  } catch (const Unstable& error) {
    warn(error.why(), what_moves(mixed.model(), state.x, error.shape()));
    return false;
  }
}

ReducedModel stable_reduced_model(const Scene& scene, const LoopSignals& signals) {
  return with_what_moves([&] { return reduced_model(scene, signals.inputs, signals.outputs); },
                         [&](const Eigen::VectorXd& shape) {
                           const Model model = model_of(scene);
                           return what_moves(model, MixedModel(model).written(1), shape);
                         });
}

ReducedModel stable_reduced_loop(const Scene& scene) {
  ReducedModel reduced = stable_reduced_model(scene, loop_signals(scene));
  reduced.n_in = static_cast<Eigen::Index>(scene.inputs.size());
  reduced.n_out = static_cast<Eigen::Index>(scene.outputs.size());
  return reduced;
}

}  // namespace stillframe::tools
