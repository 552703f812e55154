// How long a linearisation takes, what each thing that is asked for adds, and what differences of
// the nonlinear equations cost and reach instead.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>

#include "bench/machine.hpp"
#include "core/mechanics/dynamics.hpp"
#include "core/mechanics/equilibrium.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/scene/scene_reader.hpp"
#include "core/mechanics/state_space.hpp"

namespace {

using namespace stillframe;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Scene scene_named(const std::string& name) {
  return read_scene(STILLFRAME_SOURCE_DIR "/config/scenes/" + name + ".yaml");
}

/// The inputs and outputs of the generalised plant: those of the scene, and the legs.
struct Signals {
  std::vector<SceneSignal> inputs, outputs;
  explicit Signals(const Scene& scene) : inputs(scene.inputs), outputs(scene.outputs) {
    if (!scene.controller) return;
    for (const std::string& leg : scene.controller->legs) {
      SceneSignal signal;
      signal.name = signal.element = leg;
      signal.quantity = Quantity::stress;
      inputs.push_back(signal);
      outputs.push_back(signal);
    }
  }
};

void frame_all(benchmark::State& state) {
  const Scene scene = scene_named("metrology_frame");
  const Model model = make_model(scene);
  const Signals signals(scene);
  Lineariser lineariser(model, signals.inputs, signals.outputs);
  const NominalMotion rest(model);
  for (auto _ : state) {
    benchmark::DoNotOptimize(state_space(lineariser.about(rest)));
  }
}
BENCHMARK(frame_all)->Name("frame: M C D K N G, A B C D, 12 inputs, 12 outputs");

void frame_no_signals(benchmark::State& state) {
  const Scene scene = scene_named("metrology_frame");
  const Model model = make_model(scene);
  Lineariser lineariser(model, {}, {});
  const NominalMotion rest(model);
  for (auto _ : state) benchmark::DoNotOptimize(lineariser.about(rest).M.data());
}
BENCHMARK(frame_no_signals)->Name("frame: M C D K N G, no inputs, no outputs");

void frame_stiffness(benchmark::State& state) {
  const Scene scene = scene_named("metrology_frame");
  const Model model = make_model(scene);
  Lineariser lineariser(model, {}, {}, {.mass = false, .damping = false, .stiffness = true});
  const NominalMotion rest(model);
  for (auto _ : state) benchmark::DoNotOptimize(lineariser.about(rest).K.data());
}
BENCHMARK(frame_stiffness)->Name("frame: K N G alone");

/// The same scene at rest and in motion: what C, N, D2F q' and D3F q' q' cost.
void spinning_arm(benchmark::State& state, bool moving) {
  Scene scene = scene_named("spinning_arm");
  const Model model = make_model(scene);
  NominalMotion motion = nominal_motion(model);
  if (!moving) {
    motion.state.q_d_dot.setZero();
    motion.state.q_r_dot.setZero();
    motion.state.q_r_ddot.setZero();
    motion.q_d_ddot.setZero();
  }
  Lineariser lineariser(model, {}, {});
  for (auto _ : state) benchmark::DoNotOptimize(lineariser.about(motion).M.data());
}
BENCHMARK_CAPTURE(spinning_arm, at_rest, false)->Name("spinning arm, at rest");
BENCHMARK_CAPTURE(spinning_arm, in_motion, true)->Name("spinning arm, in motion");

/// Central differences of order 2, 4, 6, 8 of the accelerations: A_21 of the frame.
MatrixXd differenced_A21(const Model& model, Data& data, int order, double h) {
  static constexpr std::array<std::array<double, 4>, 4> weights = {
      {{1.0 / 2, 0, 0, 0},
       {2.0 / 3, -1.0 / 12, 0, 0},
       {3.0 / 4, -3.0 / 20, 1.0 / 60, 0},
       {4.0 / 5, -1.0 / 5, 4.0 / 105, -1.0 / 280}}};
  const VectorXd sigma_a = VectorXd::Zero(model.n_e);
  MotionState state(model);
  VectorXd q_ddot(model.n_d);
  MatrixXd A = MatrixXd::Zero(model.n_d, model.n_d);
  for (Index j = 0; j < model.n_d; ++j) {
    for (int k = 1; k <= order / 2; ++k) {
      for (const int sign : {1, -1}) {
        state.q_d(j) = sign * k * h;
        if (accelerations(model, data, state, sigma_a, q_ddot) != DynamicsStatus::ok) std::abort();
        A.col(j) += sign * weights[static_cast<size_t>(order / 2 - 1)][static_cast<size_t>(k - 1)] /
                    h * q_ddot;
      }
    }
    state.q_d(j) = 0;
  }
  return A;
}

void differences(benchmark::State& state) {
  const Model model = make_model(scene_named("metrology_frame"));
  Data data(model);
  const auto order = static_cast<int>(state.range(0));
  const double h = std::pow(10.0, static_cast<double>(-state.range(1)));
  const MatrixXd exact =
      state_matrix(linearise(model, {}, {})).bottomLeftCorner(model.n_d, model.n_d);
  MatrixXd A;
  for (auto _ : state) A = differenced_A21(model, data, order, h);
  state.counters["error"] = (A - exact).cwiseAbs().maxCoeff() / exact.cwiseAbs().maxCoeff();
}
BENCHMARK(differences)
    ->Name("frame: A21 by central differences, order/-log10 step (m)")
    ->ArgsProduct({{2, 4, 6, 8}, {2, 3, 4, 5, 6}});

}  // namespace

int main(int argc, char** argv) {
  benchmark::AddCustomContext("machine", stillframe::machine_line(STILLFRAME_FLAGS));
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
