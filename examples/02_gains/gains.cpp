// The gains of a scene, and what its sampled loop lets through from the floor to the frame.
#include <iostream>
#include <numbers>
#include <stillframe.hpp>

using namespace stillframe;

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: gains SCENE\n";
    return 2;
  }
  const Scene scene = read_scene(argv[1]);
  const ControlLoop loop = make_control_loop(scene, make_model(scene));
  std::cout << "natural frequencies (Hz): " << modes(loop.plant).natural_frequencies_hz.transpose()
            << "\nK_P\n"
            << loop.gains.K_P << "\n";

  const SceneController& block = *scene.controller;
  LoopSettings settings{.plant = loop_plant(loop.plant, loop.n_w, loop.n_y),
                        .feedback = loop.gains};
  settings.law.lead_samples = block.lead_samples;
  settings.sampling.sample_time = 1 / block.sample_rate_hz;
  settings.sampling.delay_samples = block.delay_samples;
  settings.sampling.instruments = scene.instruments;
  const SampledLoop closed = close_loop(settings);
  std::cout << "spectral radius " << spectral_radius(closed) << "\n";
  for (const double hz : {2.0, 5.0, 20.0, 100.0}) {
    const double omega = 2 * std::numbers::pi * hz;
    std::cout << hz << " Hz: open " << singular_values(loop.open({0, omega}))(0) << ", closed "
              << singular_values(transfer(closed, omega))(0) << "\n";
  }
} catch (const std::exception& error) {
  std::cerr << error.what() << "\n";
  return 2;
}
