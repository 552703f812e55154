#include "tests/plant_sim/random_settings.hpp"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iostream>
#include <random>

#include "controller/law.hpp"
#include "tests/plant_sim/frame.hpp"

namespace stillframe::test {

namespace {

/// Numbers of a generator whose output the standard fixes; it fixes none of the distributions.
class Draws {
 public:
  explicit Draws(unsigned seed) : engine_(seed) {}

  double between(double low, double high) { return low + (high - low) * unit(); }
  /// Evenly on a logarithmic axis.
  double scale(double low, double high) { return low * std::pow(high / low, unit()); }
  bool chance(double probability) { return unit() < probability; }
  int below(int end) { return static_cast<int>(unit() * end); }

 private:
  double unit() { return engine_() / 4294967296.0; }

  std::mt19937 engine_;
};

/// A corner above the sample rate would do little but make the plant stiff.
Instruments draw_instruments(Draws& draws, double sample_rate_hz) {
  Instruments has;
  has.actuator_gain = draws.between(0.6, 1.6);
  if (draws.chance(0.5)) has.actuator_lag_hz = draws.scale(100, std::min(1000.0, sample_rate_hz));
  if (draws.chance(0.5)) has.sensor_filter_hz = draws.scale(200, std::min(2000.0, sample_rate_hz));
  if (draws.chance(0.5)) has.report = Instruments::Report::commanded;
  if (draws.chance(0.4)) has.report_age_samples = 1 + draws.below(2);
  return has;
}

void draw_controller(Draws& draws, SceneController& block) {
  // In fours, so that ramps and windows are whole numbers of samples.
  block.sample_rate_hz = 4 * std::round(draws.scale(400, 2000) / 4);
  block.target_hz = {draws.scale(2, 12)};
  block.damping_ratio = {draws.between(0.4, 1.0)};
  block.delay_samples = draws.between(0, 2.5);
  if (draws.chance(0.4)) block.delay_samples = std::floor(block.delay_samples);
  block.leak_hz = draws.scale(0.1, 2);
  block.high_pass_hz = draws.chance(0.25) ? draws.scale(0.1, 1) : 0;
  // As fits the delay, somewhere about it, or none.
  const int lead = draws.below(3);
  block.lead_samples = lead == 0   ? block.delay_samples + 0.5
                       : lead == 1 ? (block.delay_samples + 0.5) * draws.between(0, 2)
                                   : 0;
  block.roll_off_hz.reset();
  if (draws.chance(0.5)) block.roll_off_hz = draws.scale(50, 400);
  block.force_limit_n.reset();  // saturation is no part of the prediction
}

/// The gains and the prediction of a changed scene.
RandomSetting predicted(std::shared_ptr<const judge::LoopDesign> frame, Scene scene) {
  const SceneController& block = *scene.controller;
  const ControlLoop loop = make_control_loop(scene, frame->model);
  controller::Gains gains = frame->gains;
  gains.sample_rate_hz = block.sample_rate_hz;
  gains.delay_samples = block.delay_samples;
  gains.leak_hz = block.leak_hz;
  gains.high_pass_hz = block.high_pass_hz;
  gains.lead_samples = block.lead_samples;
  gains.roll_off_hz = block.roll_off_hz;
  gains.force_limit_n = block.force_limit_n;
  gains.K_P = loop.gains.K_P;
  gains.K_I = loop.gains.K_I;
  gains.instruments = scene.instruments;
  RandomSetting setting{.frame = std::move(frame),
                        .scene = std::move(scene),
                        .gains = gains,
                        .law = controller::law_from_gains(gains),
                        .closed = {}};
  setting.closed = predict(setting, gains.sampling());
  setting.radius = spectral_radius(setting.closed);
  return setting;
}

}  // namespace

int ringing_samples(const RandomSetting& setting) {
  const double by_mode = 2 / std::abs(std::log(setting.radius));
  const double by_frame = 2 * setting.gains.sample_rate_hz;
  return static_cast<int>(std::min<double>(std::max(by_mode, by_frame), longest_ringing));
}

SampledLoop predict(const RandomSetting& setting, const Sampling& sampling) {
  return close_loop(sample_and_hold(setting.frame->settings.plant, sampling), setting.law);
}

RandomSettings fifty_settings() {
  const auto frame = std::make_shared<const judge::LoopDesign>(
      judge::make_loop_design(frame_file(), std::nullopt));
  Draws draws(2009);
  RandomSettings drawn;
  int stable_left = 22, near_left = 14, far_left = 14;
  while (stable_left + near_left + far_left > 0) {
    Scene scene = frame->scene;
    draw_controller(draws, *scene.controller);
    scene.instruments = draw_instruments(draws, scene.controller->sample_rate_hz);
    RandomSetting setting = predicted(frame, std::move(scene));
    ++drawn.n_drawn;
    if (longest_ringing * std::abs(std::log(setting.radius)) < 0.7) {
      ++drawn.passed_over;
      continue;
    }
    int& left = setting.predicted_stable() ? stable_left
                : setting.radius < 1.1     ? near_left
                                           : far_left;
    if (left == 0) continue;
    --left;
    drawn.settings.push_back(std::move(setting));
  }
  return drawn;
}

void print_head(std::ostream& out) {
  out << " rate target zeta delay  lead  leak  pass  roll  gain  lag filter report age    radius\n";
}

void print(std::ostream& out, const RandomSetting& setting) {
  const controller::Gains& g = setting.gains;
  const SceneController& block = *setting.scene.controller;
  const Instruments& has = g.instruments;
  const auto column = [&](int width, int digits, double value) {
    if (value == 0) {
      out << std::setw(width) << "-";
    } else {
      out << std::setw(width) << std::fixed << std::setprecision(digits) << value;
    }
  };
  column(5, 0, g.sample_rate_hz);
  column(7, 1, block.target_hz[0]);
  column(5, 2, block.damping_ratio[0]);
  column(6, 2, g.delay_samples);
  column(6, 2, g.lead_samples);
  column(6, 2, g.leak_hz);
  column(6, 2, g.high_pass_hz);
  column(6, 0, g.roll_off_hz.value_or(0));
  column(6, 2, has.actuator_gain);
  column(5, 0, has.actuator_lag_hz);
  column(7, 0, has.sensor_filter_hz);
  out << (has.report == Instruments::Report::measured ? "   meas" : "   comm");
  column(4, 0, has.report_age_samples);
  column(10, 6, setting.radius);
}

}  // namespace stillframe::test
