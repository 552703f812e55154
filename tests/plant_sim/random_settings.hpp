#pragma once

#include <iosfwd>
#include <vector>

#include "tools/loop_design.hpp"

namespace stillframe::test {

/// One loop of the metrology frame, with what is predicted of it.
struct RandomSetting {
  tools::LoopDesign design;  ///< of the frame with the scene's controller and instruments changed
  DiscreteLaw law;
  double radius = 0;  ///< predicted spectral radius

  bool predicted_stable() const { return radius < largest_stable_radius; }
};

/// Samples that a verdict may take.
inline constexpr int longest_ringing = 60'000;
/// How many a verdict takes: the mode that decides changes by exp(8) = 3000 meanwhile, whichever
/// way, and slow modes of the frame (1 Hz and more) go through their periods.
int ringing_samples(const RandomSetting& setting);

/// The predicted closed loop of a setting whose prediction is told other samplings than the plant
/// has.
SampledLoop predict(const RandomSetting& setting, const Sampling& sampling);

struct RandomSettings {
  std::vector<RandomSetting> settings;
  int passed_over = 0;  ///< draws so near to a radius of one that longest_ringing would not do
};

/// So many settings, drawn with a fixed seed, the same on every machine.
RandomSettings random_settings(int count);

/// Its settings in one line of a table, and the head of that table.
void print_head(std::ostream& out);
void print(std::ostream& out, const RandomSetting& setting);

}  // namespace stillframe::test
