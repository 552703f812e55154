#pragma once

#include <iosfwd>
#include <memory>
#include <vector>

#include "judge/loop_design.hpp"

namespace stillframe::test {

/// One loop of the metrology frame, with what is predicted of it.
struct RandomSetting {
  std::shared_ptr<const judge::LoopDesign> frame;  ///< as its files have it
  Scene scene;                                     ///< the same with these settings
  controller::Gains gains;
  DiscreteLaw law;
  SampledLoop closed;
  double radius = 0;  ///< spectral radius of closed

  bool predicted_stable() const { return radius < largest_stable_radius; }
};

/// Samples that a verdict may take.
inline constexpr int longest_ringing = 8'000;
/// How many it takes: two seconds at least, which is long against the modes of the frame, and so
/// many that the mode that decides changes by exp(2) meanwhile, whichever way, if they are not too
/// many.
int ringing_samples(const RandomSetting& setting);

/// The prediction that a setting would get were its plant sampled like this.
SampledLoop predict(const RandomSetting& setting, const Sampling& sampling);

/// Drawn with a fixed seed, the same on every machine.
struct RandomSettings {
  std::vector<RandomSetting> settings;
  int n_drawn = 0;
  int passed_over = 0;  ///< whose mode would change by less than exp(0.7) in longest_ringing
};

/// Fifty: the first 22 stable ones, the first 14 up to a radius of 1.1, where verdicts are hard,
/// and the first 14 beyond, in the order in which they come.
RandomSettings fifty_settings();

/// Its settings in one line of a table, and the head of that table.
void print_head(std::ostream& out);
void print(std::ostream& out, const RandomSetting& setting);

}  // namespace stillframe::test
