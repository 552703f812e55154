#include "tests/design_cases/case.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <complex>
#include <cstdio>

#include "core/control/continuous_loop.hpp"
#include "core/control/margins.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/singular_values.hpp"
#include "core/numerics/two_pi.hpp"

namespace stillframe::test {

namespace {

const std::filesystem::path config = std::filesystem::path(STILLFRAME_SOURCE_DIR) / "config";

LoopSettings settings_of(const Scene& scene, const ControlLoop& loop) {
  const SceneController& block = *scene.controller;
  const Sampling sampling{.sample_time = 1 / block.sample_rate_hz,
                          .delay_samples = block.delay_samples,
                          .instruments = scene.instruments,
                          .leg_gains = {},
                          .leg_delays = {}};
  const LawSampling law{.realisation = block.realisation,
                        .sample_time = sampling.sample_time,
                        .lead_samples = block.lead_samples,
                        .sensor_filter_hz = scene.instruments.sensor_filter_hz};
  return {.plant = loop_plant(loop.plant, loop.n_w, loop.n_y),
          .feedback = loop.gains,
          .law = law,
          .sampling = sampling};
}

}  // namespace

Scene case_scene(const std::string& name, const std::string& controller) {
  std::optional<std::filesystem::path> file;
  if (!controller.empty()) file = config / "controllers" / (controller + ".yaml");
  Scene scene = read_scene(config / "scenes" / (name + ".yaml"), file);
  scene.controller->force_limit_n.reset();
  return scene;
}

double Case::continuous_growth() const {
  return closed_loop_poles(settings.plant, settings.feedback).real().maxCoeff();
}

Eigen::VectorXd Case::predicted(double hz) const {
  return singular_values(transfer(closed, two_pi * hz));
}

double Case::predicted_db(double hz) const { return 20 * std::log10(predicted(hz)(0)); }

Case make_case(const Scene& scene, const std::optional<Scene>& design_scene) {
  Case made{.scene = scene,
            .model = make_model(scene),
            .loop = {},
            .settings = {},
            .closed = {},
            .radius = 0};
  made.loop = make_control_loop(made.scene, made.model);
  if (design_scene) {
    Scene other = *design_scene;
    other.controller = scene.controller;
    const ControlLoop design = make_control_loop(other, make_model(other));
    made.loop.design = design.design;
    made.loop.gains = design.gains;
  }
  made.settings = settings_of(made.scene, made.loop);
  made.closed = close_loop(made.settings);
  made.radius = spectral_radius(made.closed);
  return made;
}

DecidingPole deciding_pole(const Case& made) {
  const SampledLoop loop = [&] {
    LoopSettings feedback = made.settings;
    feedback.plant = feedback_part(feedback.plant);
    return close_loop(feedback);
  }();
  const Eigen::VectorXcd poles = loop.A.eigenvalues();
  Eigen::Index largest = 0;
  poles.cwiseAbs().maxCoeff(&largest);
  const std::complex<double> rate = std::log(poles(largest)) / loop.sample_time;
  return {.growth = rate.real(), .hz = std::abs(rate.imag()) / two_pi};
}

void print_line(const std::string& setting, const Case& made) {
  std::printf("| %-44s | %9.6f |", setting.c_str(), made.radius);
  if (made.stable()) {
    std::printf(" %5.3f |", all_leg_disk_margin(made.settings).first);
    for (const double hz : {10, 20, 50, 100}) std::printf(" %6.1f |", made.predicted_db(hz));
  } else {
    const DecidingPole pole = deciding_pole(made);
    std::printf(" grows by %.3g 1/s at %.4g Hz |", pole.growth, pole.hz);
  }
  std::printf("\n");
}

}  // namespace stillframe::test
