// Plant and law in one program, without LCM: ten seconds of a scene on its floor.
#include <cmath>
#include <iostream>
#include <stillframe.hpp>

using namespace stillframe;

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::cerr << "usage: closed_loop SCENE\n";
    return 2;
  }
  const Scene scene = read_scene(argv[1]);
  const SceneController& block = *scene.controller;
  const ControlLoop loop = make_control_loop(scene, make_model(scene));
  const auto floor = floor::read_floor_block(read_floor(scene, {})->reader, block.sample_rate_hz,
                                             static_cast<Index>(scene.inputs.size()));
  Plant plant(scene, floor::make_floor_source(floor));
  controller::Law law(sample_law(loop.gains, {.realisation = block.realisation,
                                              .sample_time = 1 / block.sample_rate_hz,
                                              .lead_samples = block.lead_samples}));
  CommandQueue queue(loop.n_legs, block.delay_samples);  // one sample or more
  Eigen::VectorXd force = Eigen::VectorXd::Zero(loop.n_legs);
  double floor_squares = 0, frame_squares = 0;
  while (plant.time() < 10) {
    const Reading& now = plant.read();
    law.step(now.sigma, now.applied_force, force);
    const std::string failed = plant.advance(queue.before(), queue.after(), queue.fraction());
    if (!failed.empty()) throw Refusal(failed);
    queue.push(force);
    floor_squares += now.floor_acceleration.head(loop.n_w).squaredNorm();
    frame_squares += now.frame_acceleration.head(loop.n_y).squaredNorm();
  }
  std::cout << "frame over floor, rms: " << std::sqrt(frame_squares / floor_squares) << "\n";
} catch (const std::exception& error) {
  std::cerr << error.what() << "\n";
  return 2;
}
