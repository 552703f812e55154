#include "tests/verification/scene_text.hpp"

#include <fstream>
#include <iomanip>
#include <regex>
#include <sstream>
#include <stdexcept>

#include "core/mechanics/buckling.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"

namespace stillframe::verification {

std::string scene_text(const std::string& name) {
  const std::string path = std::string(STILLFRAME_SOURCE_DIR) + "/config/scenes/" + name + ".yaml";
  std::ifstream file(path);
  if (!file) throw std::runtime_error(path + " cannot be read");
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string with(std::string text, const std::string& from, const std::string& to) {
  size_t at = text.find(from);
  if (at == std::string::npos) throw std::runtime_error("the scene has no '" + from + "'");
  for (; at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
  return text;
}

std::string divided(const std::string& text, int n) {
  return std::regex_replace(text, std::regex("divide: [0-9]+"), "divide: " + std::to_string(n));
}

std::string first_order(const std::string& text) {
  return with(text, "second_order: true", "second_order: false");
}

std::string without_signals(const std::string& text) {
  return text.substr(0, text.find("\ninputs:") + 1);
}

std::string blade_without_twist() {
  const std::string text =
      with(scene_text("rotating_cantilever"), "rigid: [1], GJ: 40", "rigid: [1, 2]");
  return with(text, "inertia_per_length: 1e-6, ", "");
}

std::string number(double value) {
  std::ostringstream text;
  text << std::setprecision(17) << value;
  return text.str();
}

LinearModel linear_model(const std::string& text) {
  const Scene scene = parse_scene(text, "scene");
  const Model model = make_model(scene);
  return linearise(model, nominal_motion(model), scene.inputs, scene.outputs);
}

Eigen::VectorXd frequencies_hz(const std::string& text) {
  return modes(linear_model(text)).natural_frequencies_hz;
}

Eigen::VectorXd multipliers(const std::string& text) {
  return buckling(make_model(parse_scene(text, "scene"))).load_multipliers;
}

}  // namespace stillframe::verification
