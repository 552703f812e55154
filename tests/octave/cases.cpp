#include "tests/octave/cases.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/frequency_response.hpp"
#include "core/mechanics/model/model.hpp"
#include "core/mechanics/modes.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/mechanics/state_space.hpp"
#include "core/numerics/two_pi.hpp"
#include "tests/support/augment.hpp"

namespace stillframe::octave {

namespace fs = std::filesystem;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

const fs::path folder = STILLFRAME_SOURCE_DIR "/config/scenes";

std::vector<fs::path> scene_files() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".yaml") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

/// Motions given by position or velocity become those by acceleration, with which alone the system
/// is proper.
void take_accelerations(std::vector<SceneSignal>& inputs) {
  for (SceneSignal& input : inputs) {
    switch (input.quantity) {
      case Quantity::position:
      case Quantity::velocity:
        input.quantity = Quantity::acceleration;
        break;
      case Quantity::rotation:
      case Quantity::angular_velocity:
        input.quantity = Quantity::angular_acceleration;
        break;
      case Quantity::deformation:
      case Quantity::deformation_rate:
        input.quantity = Quantity::deformation_acceleration;
        break;
      default:
        break;
    }
  }
}

OpenCase make_open_case(const fs::path& file) {
  Scene scene = read_scene(file);
  take_accelerations(scene.inputs);
  const Model model = make_model(scene);
  const LinearModel linear = linearise(model, nominal_motion(model), scene.inputs, scene.outputs);
  const StateSpace system = state_space(linear);
  OpenCase c;
  c.name = file.stem();
  c.system = test::augmented(system);
  c.A_q = system.A;
  c.poles = modes(linear).eigenvalues;
  const double fastest = c.poles.cwiseAbs().maxCoeff();
  // Up to beyond the fastest mode, and six samples to its period.
  c.omega = logarithmic_frequencies(1e-3 * fastest, 3 * fastest, 25);
  c.sample_time = 1 / fastest;
  return c;
}

/// Leaves what a loop takes: accelerations.
void keep_accelerations(std::vector<SceneSignal>& signals) {
  std::erase_if(
      signals, [](const SceneSignal& signal) { return signal.quantity != Quantity::acceleration; });
}

LoopCase make_loop_case(const std::string& name, Scene scene) {
  take_accelerations(scene.inputs);
  keep_accelerations(scene.inputs);
  for (SceneSignal& output : scene.outputs) {
    if (output.quantity == Quantity::position) output.quantity = Quantity::acceleration;
  }
  keep_accelerations(scene.outputs);
  LoopCase c;
  c.name = name;
  c.loop = make_control_loop(scene, make_model(scene));
  const SceneController& controller = *scene.controller;
  c.settings.plant = loop_plant(c.loop.plant, c.loop.n_w, c.loop.n_y);
  c.settings.feedback = c.loop.gains;
  c.settings.law.realisation = controller.realisation;
  c.settings.law.lead_samples = controller.lead_samples;
  c.settings.sampling.sample_time = 1 / controller.sample_rate_hz;
  c.settings.sampling.delay_samples = controller.delay_samples;
  c.settings.sampling.instruments = scene.instruments;
  c.settings.sampling.leg_gains = VectorXd::Ones(c.loop.n_legs);
  c.settings.sampling.leg_delays = VectorXd::Zero(c.loop.n_legs);
  // Far below the modes, accelerations are differences of terms (omega_mode / omega)^2 times as
  // large, and at (omega T)^2 from a double pole at z = 1 the position of the floor is told from
  // its acceleration: 1e-9 of them is asked for where these cost no more than six digits.
  const double rate = controller.sample_rate_hz;
  c.omega = two_pi * logarithmic_frequencies(0.3, 1000, 25);
  c.omega_sampled = two_pi * logarithmic_frequencies(rate / 1000, 0.49 * rate, 25);
  return c;
}

SceneController cart_controller() {
  SceneController controller;
  controller.legs = {"spring"};
  controller.target_hz = {1};
  controller.damping_ratio = {0.7};
  controller.sample_rate_hz = 200;
  controller.delay_samples = 0.25;
  controller.leak_hz = 0.01;
  return controller;
}

/// The mass's position as the dof: the floor then strains the spring and has states of its own.
void take_position(Scene& scene) {
  SceneDof& dof = scene.dofs.front();
  dof.element.clear();
  dof.node = "mass";
  dof.direction = Eigen::Vector3d::UnitX();
}

using Change = void (*)(Scene&);

void late(Scene& s) { s.controller->delay_samples = 2.3; }
void lag(Scene& s) {
  s.instruments.actuator_lag_hz = 300;
  s.instruments.actuator_gain = 1.2;
}
void filter(Scene& s) { s.instruments.sensor_filter_hz = 200; }
void old_commands(Scene& s) {
  lag(s);
  s.instruments.report = Instruments::Report::commanded;
  s.instruments.report_age_samples = 2;
}
void corners(Scene& s) {
  s.controller->high_pass_hz = 0.1;
  s.controller->roll_off_hz = 200;
}
void all(Scene& s) {
  for (const Change change : {late, filter, old_commands, corners}) change(s);
}
void plain_pi(Scene& s) {
  s.controller->realisation = Realisation::naive_pi;
  s.controller->roll_off_hz = 200;
}
void no_leak(Scene& s) { s.controller->leak_hz = 0; }

/// The metrology frame's loop with one part after another.
constexpr std::pair<const char*, Change> frame_changes[] = {
    {"frame_late_by_a_fraction", late}, {"frame_with_lag", lag},
    {"frame_with_filter", filter},      {"frame_with_old_commands", old_commands},
    {"frame_with_corners", corners},    {"frame_with_all", all},
    {"frame_by_plain_pi", plain_pi},    {"frame_without_leak", no_leak},
};

/// Legs that differ: in gain, and in delay by fractions and by whole samples.
LoopCase unlike_legs(LoopCase c) {
  c.name = "frame_of_unlike_legs";
  const Eigen::Index m = c.loop.n_legs;
  c.settings.sampling.leg_gains = VectorXd::LinSpaced(m, 0.8, 1.3);
  c.settings.sampling.leg_delays = VectorXd::Zero(m);
  c.settings.sampling.leg_delays.head<3>() << 0.5, 1.25, 2;
  return c;
}

std::vector<LoopCase> make_loop_cases() {
  std::vector<LoopCase> cases;
  for (const fs::path& file : scene_files()) {
    const Scene scene = read_scene(file);
    if (scene.controller) cases.push_back(make_loop_case(file.stem(), scene));
  }
  cases.push_back(
      make_loop_case("preloaded_frame",
                     read_scene(folder / "preloaded_frame.yaml",
                                folder.parent_path() / "controllers" / "force_feedback_5hz.yaml")));
  Scene cart = read_scene(folder / "cart.yaml");
  cart.controller = cart_controller();
  cases.push_back(make_loop_case("cart", cart));
  take_position(cart);
  cases.push_back(make_loop_case("cart_by_position", cart));
  for (const auto& [name, change] : frame_changes) {
    Scene frame = read_scene(folder / "metrology_frame.yaml");
    change(frame);
    cases.push_back(make_loop_case(name, frame));
    if (change == all) cases.push_back(unlike_legs(cases.back()));
  }
  return cases;
}

MatrixXd number(double value) { return MatrixXd::Constant(1, 1, value); }

}  // namespace

const std::vector<OpenCase>& open_cases() {
  static const std::vector<OpenCase> cases = [] {
    std::vector<OpenCase> made;
    for (const fs::path& file : scene_files()) made.push_back(make_open_case(file));
    return made;
  }();
  return cases;
}

const std::vector<LoopCase>& loop_cases() {
  static const std::vector<LoopCase> cases = make_loop_cases();
  return cases;
}

bool is_designed_on_its_legs(const LoopCase& c) { return c.loop.design.Q.isIdentity(0); }

Given given(const OpenCase& c) {
  return {{"A", c.system.A},
          {"B", c.system.B},
          {"C", c.system.C},
          {"D", c.system.D},
          {"A_q", c.A_q},
          {"omega", c.omega},
          {"sample_time", number(c.sample_time)}};
}

Given given(const LoopCase& c) {
  const LoopPlant& plant = c.settings.plant;
  const ForceFeedback& feedback = c.settings.feedback;
  const Sampling& sampling = c.settings.sampling;
  const Instruments& instruments = sampling.instruments;
  Given out{{"A", plant.A},
            {"B_w", plant.B_w},
            {"B_u", plant.B_u},
            {"C_y", plant.C_y},
            {"D_yw", plant.D_yw},
            {"D_yu", plant.D_yu},
            {"C_sigma", plant.C_sigma},
            {"n_exogenous", number(static_cast<double>(plant.n_exogenous))},
            {"K_P", feedback.K_P},
            {"K_I", feedback.K_I},
            {"leak", number(feedback.leak)},
            {"high_pass", number(feedback.high_pass)},
            {"roll_off", number(feedback.roll_off)},
            {"tau", number(feedback.lead)},
            {"naive", number(c.settings.law.realisation == Realisation::naive_pi)},
            {"lead", number(c.settings.law.lead_samples)},
            {"sample_time", number(sampling.sample_time)},
            {"delays", (sampling.leg_delays.array() + sampling.delay_samples).matrix()},
            {"gains", instruments.actuator_gain * sampling.leg_gains},
            {"lag", number(two_pi * instruments.actuator_lag_hz)},
            {"filter", number(two_pi * instruments.sensor_filter_hz)},
            {"measured", number(instruments.report == Instruments::Report::measured &&
                                instruments.actuator_lag_hz > 0)},
            {"report_age", number(instruments.report_age_samples)},
            {"omega", c.omega},
            {"omega_sampled", c.omega_sampled}};
  if (is_designed_on_its_legs(c)) {
    out["M"] = c.loop.design.legs.M;
    out["K"] = c.loop.design.legs.K;
  }
  return out;
}

}  // namespace stillframe::octave
