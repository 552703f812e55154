// From a scene to gains and a prediction, in one page: print what the loop does to the floor at 20
// Hz.
#include <iostream>
#include <numbers>

#include "core/control/design/control_loop.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/scene/scene_reader.hpp"

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: first SCENE\n";
    return 2;
  }
  const stillframe::Scene scene = stillframe::read_scene(argv[1]);
  const stillframe::Model model = stillframe::make_model(scene);
  const stillframe::ControlLoop loop = stillframe::make_control_loop(scene, model);

  std::cout << "natural frequencies (Hz): "
            << stillframe::modes(loop.plant).natural_frequencies_hz.transpose() << "\n";
  std::cout << "K_P:\n" << loop.gains.K_P << "\n";

  const std::complex<double> s(0, 2 * std::numbers::pi * 20);
  std::cout << "largest singular value at 20 Hz: open "
            << stillframe::singular_values(loop.open(s))(0) << ", closed by the continuous law "
            << stillframe::singular_values(loop.closed(s))(0) << "\n";
} catch (const std::exception& error) {
  std::cerr << error.what() << "\n";
  return 2;
}
