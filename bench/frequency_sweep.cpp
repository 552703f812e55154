// Speed and error of transfer functions and their singular values: the 12 x 12 matrix of the
// metrology frame (six floor accelerations and six leg forces in) at 1000 frequencies from 0.1 to
// 1000 Hz, one thread. bench/race_octave runs it against Octave.
#include "core/systems/frequency_sweep.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "bench/machine.hpp"
#include "core/numerics/singular_values.hpp"
#include "core/numerics/two_pi.hpp"
#include "tests/support/frame_state_space.hpp"
#include "tests/support/quadruple.hpp"

namespace {

using namespace stillframe;
using Eigen::Index;
using Eigen::MatrixXd;
using test::FrameOutputs;
namespace fs = std::filesystem;

constexpr FrameOutputs plants[] = {FrameOutputs::accelerations_and_stresses,
                                   FrameOutputs::accelerations_and_elongations};
constexpr const char* plant_names[] = {"accelerations and stresses (rank 6)",
                                       "accelerations and elongations (rank 12)"};

Eigen::VectorXd frequencies() {
  const Eigen::ArrayXd exponent = Eigen::ArrayXd::LinSpaced(1000, -1, 3);
  return two_pi * (exponent * std::log(10.0)).exp();
}

void transfer_functions(benchmark::State& state) {
  FrequencySweep sweep(frame_state_space(plants[state.range(0)]));
  const Eigen::VectorXd omega = frequencies();
  Eigen::MatrixXcd G(sweep.n_outputs(), sweep.n_inputs());
  for (auto _ : state) {
    for (double w : omega) {
      sweep.evaluate({0.0, w}, G);
      benchmark::DoNotOptimize(G.data());
    }
  }
  state.SetItemsProcessed(state.iterations() * omega.size());
}
BENCHMARK(transfer_functions)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

void transfer_functions_with_singular_values(benchmark::State& state) {
  const StateSpace system = frame_state_space(plants[state.range(0)]);
  const Eigen::VectorXd omega = frequencies();
  for (auto _ : state) benchmark::DoNotOptimize(singular_values_over(system, omega));
  state.SetItemsProcessed(state.iterations() * omega.size());
}
BENCHMARK(transfer_functions_with_singular_values)->Arg(0)->Arg(1)->Unit(benchmark::kMicrosecond);

void singular_values_of(benchmark::State& state) {
  const Index rows = state.range(0), columns = state.range(1);
  std::srand(1);
  std::vector<Eigen::MatrixXcd> G;
  for (int i = 0; i < 100; ++i) G.push_back(Eigen::MatrixXcd::Random(rows, columns));
  SingularValues singular_values(rows, columns);
  MatrixXd values(std::min(rows, columns), 100);
  for (auto _ : state) {
    singular_values.compute(G.data(), 100, values);
    benchmark::DoNotOptimize(values.data());
  }
  state.SetItemsProcessed(state.iterations() * 100);
}
BENCHMARK(singular_values_of)->Args({12, 12})->Args({6, 6})->Args({12, 6})->Args({3, 8});

void write(const fs::path& file, const MatrixXd& X) {
  std::ofstream out(file);
  out.precision(17);
  out << X << '\n';
}

MatrixXd read(const fs::path& file, Index rows, Index columns) {
  std::ifstream in(file);
  MatrixXd out(rows, columns);
  for (Index i = 0; i < rows; ++i) {
    for (Index j = 0; j < columns; ++j) in >> out(i, j);
  }
  if (!in) throw std::runtime_error("cannot read " + file.string());
  return out;
}

/// The plants with one column an input, as Octave knows them: here only accelerations act.
void write_plants(const fs::path& folder) {
  write(folder / "omega.txt", frequencies());
  for (int plant = 0; plant < 2; ++plant) {
    const StateSpace system = frame_state_space(plants[plant]);
    const auto file = [&](const char* name) {
      return folder / (std::string(name) + "_" + std::to_string(plant + 1) + ".txt");
    };
    MatrixXd B(12, 12), D(12, 12);
    for (Index j = 0; j < 12; ++j) {
      B.col(j) = system.B.col(system.columns[static_cast<size_t>(j)].first);
      D.col(j) = system.D.col(system.columns[static_cast<size_t>(j)].first);
    }
    write(file("A"), system.A);
    write(file("B"), B);
    write(file("C"), system.C);
    write(file("D"), D);
  }
}

/// Answers every "go" with microseconds of processor time a frequency, set-up and memory included.
void serve(const fs::path& folder) {
  const MatrixXd omega = read(folder / "omega.txt", 1000, 1);
  const StateSpace systems[] = {frame_state_space(plants[0]), frame_state_space(plants[1])};
  MatrixXd values[] = {singular_values_over(systems[0], omega),
                       singular_values_over(systems[1], omega)};
  std::cout << "ready" << std::endl;
  for (std::string line; std::getline(std::cin, line) && line == "go";) {
    for (int plant = 0; plant < 2; ++plant) {
      const std::clock_t begin = std::clock();
      values[plant] = singular_values_over(systems[plant], omega);
      const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
      std::cout << 1e6 * seconds / static_cast<double>(omega.size()) << ' ';
    }
    std::cout << std::endl;
  }
  for (int plant = 0; plant < 2; ++plant) {
    write(folder / ("stillframe_" + std::to_string(plant + 1) + ".txt"), values[plant]);
  }
}

void print_times(const fs::path& folder) {
  std::ifstream in(folder / "times.txt");
  std::vector<std::vector<double>> columns(8);
  for (double value; in >> value;) {
    std::vector<double> row{value};
    for (int i = 1; i < 8; ++i) {
      in >> value;
      row.push_back(value);
    }
    for (size_t i = 0; i < 8; ++i) columns[i].push_back(row[i]);
  }
  const auto median = [](std::vector<double> values) {
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
  };
  const char* ways[] = {"freqresp, svd", "sigma", "backslash, svd"};
  for (size_t plant = 0; plant < 2; ++plant) {
    const auto& own = columns[6 + plant];
    std::printf("%s, %zu rounds: stillframe %.2f us of processor time a frequency\n",
                plant_names[plant], own.size(), median(own));
    for (size_t way = 0; way < 3; ++way) {
      const auto& other = columns[3 * plant + way];
      std::vector<double> ratios;
      for (size_t i = 0; i < own.size(); ++i) ratios.push_back(other[i] / own[i]);
      std::printf("  Octave, %-15s %6.2f us, %5.1f times as long (%.1f to %.1f)\n", ways[way],
                  median(other), median(ratios), *std::min_element(ratios.begin(), ratios.end()),
                  *std::max_element(ratios.begin(), ratios.end()));
    }
  }
}

/// Largest error of every singular value over all frequencies, against 113 bits.
void print_errors(const fs::path& folder) {
  const MatrixXd omega = read(folder / "omega.txt", 1000, 1);
  for (int plant = 0; plant < 2; ++plant) {
    const std::string end = "_" + std::to_string(plant + 1) + ".txt";
    const MatrixXd values[] = {read(folder / ("stillframe" + end), 12, 1000),
                               read(folder / ("octave" + end), 12, 1000)};
    const StateSpace system = frame_state_space(plants[plant]);
    Eigen::ArrayXXd relative = Eigen::ArrayXXd::Zero(12, 2), absolute = relative;
    Eigen::ArrayXd smallest = Eigen::ArrayXd::Ones(12);
    for (Index i = 0; i < omega.size(); i += 5) {
      const Eigen::ArrayXd reference =
          test::quadruple_singular_values(test::quadruple_transfer(system, {0.0, omega(i)}));
      smallest = smallest.min(reference / reference(0));
      for (int program = 0; program < 2; ++program) {
        const Eigen::ArrayXd error = (values[program].col(i).array() - reference).abs();
        relative.col(program) = relative.col(program).max(error / reference);
        absolute.col(program) = absolute.col(program).max(error / reference(0));
      }
    }
    std::printf("%s: largest error of each singular value, every fifth frequency\n",
                plant_names[plant]);
    std::printf("   |          | of itself           | of the largest\n");
    std::printf(" i | least s/s1 stillframe    Octave stillframe    Octave\n");
    for (Index i = 0; i < 12; ++i) {
      std::printf("%2d |  %8.1e   %8.1e  %8.1e   %8.1e  %8.1e\n", static_cast<int>(i + 1),
                  smallest(i), relative(i, 0), relative(i, 1), absolute(i, 0), absolute(i, 1));
    }
  }
}

/// Error of G next to the undamped poles of the frame, and of elimination on s I - A.
void print_near_poles() {
  const StateSpace system = frame_state_space(plants[1]);
  FrequencySweep sweep(system);
  std::printf("Next to an undamped pole: |G - G_113 bits| / |G|, the worst of the six modes\n");
  std::printf(" relative distance   this program   elimination on s I - A\n");
  for (double distance : {1e-2, 1e-3, 1e-4, 1e-6, 1e-9, 1e-12}) {
    double error = 0, plain = 0;
    for (const std::complex<double>& pole : sweep.poles()) {
      if (pole.imag() < 0) continue;
      const std::complex<double> s(0.0, pole.imag() * (1 + distance));
      const Eigen::MatrixXcd exact = test::rounded(test::quadruple_transfer(system, s));
      Eigen::MatrixXcd G(12, 12), B(12, 12), D(12, 12);
      sweep.evaluate(s, G);
      error = std::max(error, (G - exact).norm() / exact.norm());
      for (Index j = 0; j < 12; ++j) {
        B.col(j) = system.B.col(system.columns[static_cast<size_t>(j)].first);
        D.col(j) = system.D.col(system.columns[static_cast<size_t>(j)].first);
      }
      Eigen::MatrixXcd pencil = -system.A;
      pencil.diagonal().array() += s;
      G = system.C * pencil.partialPivLu().solve(B) + D;
      plain = std::max(plain, (G - exact).norm() / exact.norm());
    }
    std::printf("      %8.0e         %8.1e        %8.1e\n", distance, error, plain);
  }
}

}  // namespace

int main(int argc, char** argv) try {
  const std::string way = argc == 3 ? argv[1] : "";
  if (way == "--write") {
    write_plants(argv[2]);
  } else if (way == "--serve") {
    serve(argv[2]);
  } else if (way == "--compare") {
    std::cout << machine_line(STILLFRAME_FLAGS) << std::endl;
    print_times(argv[2]);
    print_errors(argv[2]);
  } else {
    std::cout << machine_line(STILLFRAME_FLAGS) << std::endl;
    benchmark::Initialize(&argc, argv);
    if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    print_near_poles();
  }
} catch (const std::exception& error) {
  std::cerr << error.what() << "\n";
  return 2;
}
