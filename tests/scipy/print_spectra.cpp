// print_spectra RECORDING COLUMN SEGMENT_LENGTH: Welch's spectrum of one column of a recording, and
// its one-third-octave velocities, for spectra.py to compare with scipy's.
#include <cstdio>
#include <cstdlib>
#include <exception>

#include "plant_sim/floor/recording_file.hpp"
#include "report/spectra/spectra.hpp"

int main(int argc, char** argv) try {
  if (argc != 4) {
    std::fprintf(stderr, "usage: print_spectra RECORDING COLUMN SEGMENT_LENGTH\n");
    return 2;
  }
  const auto recording = stillframe::floor::read_recording(argv[1]);
  const Eigen::VectorXd x = recording.acceleration.row(std::atoi(argv[2]));
  const auto psd = stillframe::report::welch(x, recording.sample_rate_hz, std::atoi(argv[3]));
  for (Eigen::Index k = 0; k < psd.density.size(); ++k) {
    std::printf("psd %.17g %.17g\n", psd.frequency_hz(k), psd.density(k));
  }
  const Eigen::VectorXd levels = stillframe::report::third_octave_velocity(psd);
  const auto bands = stillframe::report::third_octave_bands();
  for (Eigen::Index k = 0; k < levels.size(); ++k) {
    std::printf("band %.17g %.17g\n", bands[static_cast<std::size_t>(k)].nominal_hz, levels(k));
  }
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 2;
}
