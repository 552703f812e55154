// One contender of scripts/bench_large_motion: Simbody.
#include <cmath>
#include <fstream>
#include <iostream>
#include <sstream>

#include "bench/large_motion/mechanism.hpp"
#include "bench/large_motion/result.hpp"

int main(int argc, char** argv) try {
  using namespace stillframe::race;
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (words.size() != 5) {
    std::cerr
        << "usage: bench_large_motion_simbody MECHANISM.json METHOD ACCURACY SAMPLES AMPLITUDE\n";
    return 2;
  }
  std::ostringstream text;
  text << std::ifstream(words[0]).rdbuf();
  const Mechanism mechanism = from_text(text.str());
  const Eigen::MatrixXd inputs = shaking(static_cast<Eigen::Index>(mechanism.base_inputs.size()),
                                         words[3], mechanism.sample_time, words[4]);
  print_runs(mechanism.sample_time,
             [&] { return simbody_run(mechanism, inputs, words[1], std::stod(words[2])); });
} catch (const std::exception& error) {
  std::cerr << error.what() << "\n";
  return 4;
}
