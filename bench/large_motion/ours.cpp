// One contender of scripts/bench_large_motion: the plant simulator; or the mechanism for others.
#include <iostream>

#include "bench/large_motion/describe.hpp"
#include "bench/large_motion/our_runs.hpp"
#include "bench/large_motion/result.hpp"
#include "core/mechanics/scene/plant_methods.hpp"
#include "core/mechanics/scene/scene_reader.hpp"

int main(int argc, char** argv) try {
  using namespace stillframe;
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() == 2 && words[0] == "mechanism") {
    std::cout << race::to_text(race::mechanism_of(read_scene(words[1]))) << "\n";
    return 0;
  }
  if (words.size() != 5) {
    std::cerr << "usage: bench_large_motion mechanism SCENE | SCENE METHOD TOLERANCE SAMPLES "
                 "AMPLITUDE\n";
    return 2;
  }
  const Scene scene = read_scene(words[0]);
  const double sample_time = 1 / scene.controller->sample_rate_hz;
  const Eigen::MatrixXd inputs = race::shaking(static_cast<Eigen::Index>(scene.inputs.size()),
                                               words[3], sample_time, words[4]);
  for (const auto& [name, method] : plant_methods) {
    if (name != words[1]) continue;
    race::print_runs(sample_time,
                     [&] { return race::our_run(scene, inputs, method, std::stod(words[2])); });
    return 0;
  }
  std::cerr << "no method " << words[1] << "\n";
  return 2;
} catch (const std::exception& error) {
  std::cerr << error.what() << "\n";
  return 4;
}
