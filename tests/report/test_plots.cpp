#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <stdexcept>

#include "core/errors/input_error.hpp"
#include "report/identification/comparison.hpp"
#include "report/plots/gnuplot.hpp"
#include "report/plots/plot_robustness.hpp"
#include "report/plots/plot_trade.hpp"
#include "report/plots/plots.hpp"
#include "report/spectra/spectra.hpp"
#include "tests/report/expect_error.hpp"
#include "tests/report/sample_log.hpp"
#include "tests/report/toy_frame.hpp"
#include "tests/support/scratch_folder.hpp"

namespace stillframe::report {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using std::filesystem::path;

/// Width and height from the header of a PNG file, 0 x 0 if it is none.
std::pair<unsigned, unsigned> png_size(const path& file) {
  std::ifstream stream(file, std::ios::binary);
  unsigned char header[24] = {};
  stream.read(reinterpret_cast<char*>(header), sizeof header);
  if (std::string(header + 1, header + 4) != "PNG") return {0, 0};
  const auto number = [&](int at) {
    return header[at] << 24U | header[at + 1] << 16U | header[at + 2] << 8U | header[at + 3];
  };
  return {number(16), number(20)};
}

class Plots : public ::testing::Test {
 protected:
  /// Where pictures are kept to be looked at, if the environment says so.
  path picture(const std::string& name) const {
    const char* folder = std::getenv("STILLFRAME_TEST_PICTURES");
    return folder != nullptr ? path(folder) / name : folder_ / name;
  }

  void expect_picture(const path& file) const {
    EXPECT_EQ(png_size(file), (std::pair<unsigned, unsigned>(1600, 1000)));
  }

  /// What `draw` gives gnuplot to do.
  template <class F>
  std::string script_of(const F& draw) const {
    const path program = folder_ / "gnuplot";
    std::ofstream(program) << "#!/bin/sh\n/bin/cat > \"${0%/*}/script\"\necho picture\n";
    std::filesystem::permissions(program, std::filesystem::perms::owner_all);
    const std::string before = std::getenv("PATH");
    setenv("PATH", folder_.path().c_str(), 1);
    draw();
    setenv("PATH", before.c_str(), 1);
    std::ifstream script(folder_ / "script");
    return {std::istreambuf_iterator<char>(script), {}};
  }

  test::ScratchFolder folder_;
};

/// Toy responses as a run would leave them, with a scatter of 0.05 dB on the measured ones.
SingularValuePlot toy_singular_values() {
  const toy::Frame frame;
  const SampledPlant plant = sample_and_hold(frame.plant(), toy::sampled_at(2.5e-4));
  const SampledLoop open = open_loop(plant);
  const SampledLoop closed =
      close_loop(plant, frame.law(2 * toy::pi * 5, 0.7, 2 * toy::pi * 0.05, 2.5e-4));
  SingularValuePlot plot;
  plot.title = "toy_frame at 4000 Hz, lock-step: floor to frame";
  for (int i = 0; i <= 600; ++i)
    plot.frequencies_hz.push_back(std::pow(10, -0.3 + 2.6 * i / 600.0));
  plot.open_predicted = predicted_singular_values(open, plot.frequencies_hz);
  plot.closed_predicted = predicted_singular_values(closed, plot.frequencies_hz);
  for (int i = 0; i < 40; ++i) {
    const double f = std::round(2 * std::pow(10, 2.0 * i / 39)) / 2;
    if (plot.open_measured.frequencies_hz.empty() || f > plot.open_measured.frequencies_hz.back()) {
      plot.open_measured.frequencies_hz.push_back(f);
    }
  }
  plot.closed_measured.frequencies_hz = plot.open_measured.frequencies_hz;
  std::srand(1);
  const auto scattered = [&](const SampledLoop& loop) {
    const MatrixXd exact = predicted_singular_values(loop, plot.open_measured.frequencies_hz);
    const MatrixXd scatter = MatrixXd::Random(exact.rows(), exact.cols());
    return MatrixXd(exact.array() * (1 + 0.006 * scatter.array()));
  };
  plot.open_measured.singular_values = scattered(open);
  plot.closed_measured.singular_values = scattered(closed);
  plot.target_frequency_hz = 5;
  plot.target_damping = 0.7;
  return plot;
}

TEST_F(Plots, SingularValues) {
  const path file = picture("singular_values.png");
  plot_singular_values(toy_singular_values(), file);
  expect_picture(file);
}

TEST_F(Plots, SingularValuesWithoutMeasurement) {
  SingularValuePlot plot = toy_singular_values();
  plot.open_measured = {};
  plot.closed_measured = {};
  plot.closed_predicted.resize(0, 0);
  plot.title = "It's a $name with \"quotes\", _underscores_ and {braces}";
  const path file = picture("singular values, it's predicted.png");
  plot_singular_values(plot, file);
  expect_picture(file);
}

TEST_F(Plots, Differences) {
  const SingularValuePlot values = toy_singular_values();
  std::srand(2);
  const MatrixXd noise = 0.05 * MatrixXd::Random(values.open_measured.singular_values.rows(), 3);
  const path file = picture("differences.png");
  MatrixXd closed = -0.5 * noise;
  closed.bottomRows(4).setConstant(std::nan(""));
  plot_differences({.title = "Measured against the sampled-data prediction",
                    .frequencies_hz = values.open_measured.frequencies_hz,
                    .open_db = noise,
                    .closed_db = closed},
                   file);
  expect_picture(file);
}

/// One direction, a sample a millisecond.
struct ToyMotion {
  std::string axis;
  VectorXd floor, passive, active;
};

/// Noise of the floor, and what a lightly damped and a well isolated frame make of it.
std::vector<ToyMotion> toy_motion() {
  std::vector<ToyMotion> axes;
  std::srand(3);
  int i = 0;
  for (const char* axis : {"x", "y", "z"}) {
    const Index n = 60000;
    const VectorXd noise = 2e-3 * VectorXd::Random(n);
    VectorXd floor(n), passive(n), active(n);
    double low = 0, x = 0, v = 0, slow = 0;
    const double omega = 2 * toy::pi * (13.9 + 10 * i++);
    for (Index k = 0; k < n; ++k) {
      low += 0.3 * (noise(k) - low);
      const double a = -omega * omega * x - 2 * 0.01 * omega * v - low;
      v += 1e-3 * a;
      x += 1e-3 * v;
      slow += 0.01 * (low - slow);
      floor(k) = low;
      passive(k) = a + low;
      active(k) = slow;
    }
    axes.push_back({axis, floor, passive, active});
  }
  return axes;
}

/// Every part of 40 samples: when, smallest, largest.
MatrixXd parts_of(const VectorXd& x) {
  MatrixXd rows(x.size() / 40, 3);
  for (Index i = 0; i < rows.rows(); ++i) {
    const auto part = x.segment(40 * i, 40);
    rows.row(i) << 0.04 * static_cast<double>(i), part.minCoeff(), part.maxCoeff();
  }
  return rows;
}

TEST_F(Plots, Histories) {
  const path file = picture("histories.png");
  HistoryPlot plot{.title = "mikb_floor_200hz times 8.9: acceleration of floor and frame",
                   .axes = {}};
  for (const ToyMotion& m : toy_motion()) {
    plot.axes.push_back({m.axis, parts_of(m.floor), parts_of(m.passive), parts_of(m.active)});
  }
  // Lost samples leave parts without a value.
  plot.axes[1].active.block(100, 1, 50, 2).setConstant(std::nan(""));
  plot_histories(plot, file);
  expect_picture(file);
}

/// A loop that takes over shakes its frame more than the floor does, for a moment: what is small
/// afterwards is still drawn over what is large.
TEST_F(Plots, HistoriesHideNoSignalBehindALongerOne) {
  MatrixXd floor(100, 3), active(100, 3);
  for (Index i = 0; i < 100; ++i) {
    const double size = i < 2 ? 0.01 : 1e-4;
    floor.row(i) << static_cast<double>(i), -3e-3, 3e-3;
    active.row(i) << static_cast<double>(i), -size, size;
  }
  const HistoryPlot plot{.title = "", .axes = {{"a", floor, {}, active}}};
  const std::string script = script_of([&] { plot_histories(plot, folder_ / "a.png"); });
  const auto drawn = script.rfind("plot $");
  ASSERT_NE(drawn, std::string::npos);
  EXPECT_LT(script.find("$floor", drawn), script.find("$active", drawn)) << script.substr(drawn);
}

TEST_F(Plots, ThirdOctaves) {
  OctavePlot plot{.title = "One-third-octave velocity of floor and frame", .axes = {}};
  for (const ToyMotion& history : toy_motion()) {
    const auto bands = [](const VectorXd& a) {
      return third_octave_velocity(welch(a, 1000, 16000));
    };
    plot.axes.push_back(
        {history.axis, bands(history.floor), bands(history.passive), bands(history.active)});
  }
  path file = picture("third_octaves.png");
  plot_third_octaves(plot, file);
  expect_picture(file);
  // Six legs, and no active run.
  const auto three = plot.axes;
  plot.axes.insert(plot.axes.end(), three.begin(), three.end());
  for (AxisBands& axis : plot.axes) {
    axis.active.resize(0);
    axis.axis = "leg_" + axis.axis;
  }
  file = picture("third_octaves_six.png");
  plot_third_octaves(plot, file);
  expect_picture(file);
}

/// Low panels have room for three labels of tics, and for every other name of a criterion.
TEST_F(Plots, ManyPanelsHaveFewerLabels) {
  HistoryPlot histories{.title = "", .axes = {}};
  OctavePlot octaves{.title = "", .axes = {}};
  for (const double size : {0.03, 0.03, 0.03, 0.5, 0.5}) {
    const MatrixXd rows{{0, -size, size}, {1, -0.5 * size, size}};
    histories.axes.push_back({"a", rows, {}, {}});
    octaves.axes.push_back({"a", VectorXd::LinSpaced(20, 1e-9, 1e-3), {}, {}});
  }
  const auto tics = [&] {
    const std::string script = script_of([&] { plot_histories(histories, folder_ / "a.png"); });
    const auto has = [&](double tic) {
      return script.find("set ytics (" + plot_number(-tic) + ", 0, " + plot_number(tic) + ")") !=
             std::string::npos;
    };
    return std::pair{has(20), has(500)};
  };
  EXPECT_EQ(tics(), (std::pair{true, true}));
  histories.axes.resize(3);
  EXPECT_EQ(tics(), (std::pair{false, false}));
  const auto named = [&](const char* criterion) {
    const std::string script = script_of([&] { plot_third_octaves(octaves, folder_ / "a.png"); });
    return script.find(std::string("'") + criterion + "' at") != std::string::npos;
  };
  EXPECT_TRUE(named("VC-A") && named("VC-C"));
  EXPECT_FALSE(named("VC-B"));
  octaves.axes.resize(1);  // the picture's whole height
  for (AxisBands& axis : octaves.axes) axis.floor.setConstant(1e-5);
  EXPECT_TRUE(named("VC-A") && named("VC-B"));
}

TEST_F(Plots, NumbersAndTextSurviveGnuplot) {
  EXPECT_EQ(std::stod(plot_number(-1.25e-7)), -1.25e-7);
  EXPECT_EQ(plot_number(std::nan("")), "NaN");
  EXPECT_EQ(plot_text("it's"), "'it''s'");
}

TEST_F(Plots, RefusesShapesThatDoNotMatch) {
  SingularValuePlot plot = toy_singular_values();
  plot.frequencies_hz.pop_back();
  expect_error<std::invalid_argument>([&] { plot_singular_values(plot, folder_ / "a.png"); },
                                      "open loop, predicted: 601 rows for 600 frequencies");
  expect_error<std::invalid_argument>([&] { plot_third_octaves({}, folder_ / "a.png"); },
                                      "one to six");
  expect_error<std::invalid_argument>(
      [&] {
        plot_third_octaves({"", {{"x", VectorXd::Zero(3), {}, {}}}}, folder_ / "a.png");
      },
      "3 one-third-octave bands, expected 20");
}

TradePlot toy_trade() {
  const VectorXd rates{{100, 1000, 10000}}, none = VectorXd::Constant(3, std::nan(""));
  return {
      .title = "target, sample rate, delay",
      .rates_hz = rates,
      .columns = {{"delay 0 samples",
                   {{"1.2 Hz", none, none}, {"3 Hz", none, none}, {"6 Hz", rates / 1e4, rates}}},
                  {"delay 1 sample",
                   {{"1.2 Hz", none, none}, {"3 Hz", rates / 1e4, rates}, {"6 Hz", none, none}}}}};
}

TEST_F(Plots, Trade) {
  path file = picture("trade.png");
  plot_trade(toy_trade(), file);
  expect_picture(file);
  TradePlot unstable = toy_trade();
  for (TradePlotColumn& column : unstable.columns) column.curves.resize(1);
  file = picture("trade_unstable.png");
  plot_trade(unstable, file);
  expect_picture(file);
}

TEST_F(Plots, TradeNamesTheCurvesThatItDrawsAndTheBoundsOfARate) {
  const std::string script = script_of([&] { plot_trade(toy_trade(), folder_ / "a.png"); });
  EXPECT_EQ(script.find("target 1.2 Hz"), std::string::npos);
  for (const char* words : {"target 3 Hz", "target 6 Hz", "at least\\n0.5", "at most\\n3 dB"}) {
    EXPECT_NE(script.find(words), std::string::npos) << words;
  }
}

TEST_F(Plots, TheNominalDampingStandsInFrontOfTheBars) {
  const VectorXd gain{{1, 2}};
  const std::string script = script_of([&] {
    plot_robustness({.title = "",
                     .frequencies_hz = {1, 10},
                     .nominal = gain,
                     .low = {},
                     .high = {},
                     .most = {},
                     .worst = {},
                     .damping = {{0, 1}},
                     .damping_width = 0.005,
                     .nominal_damping = 0.004},
                    folder_ / "a.png");
  });
  EXPECT_NE(script.find("graph 1 nohead front"), std::string::npos) << script;
}

TEST_F(Plots, FailuresAreSaidAndLeaveNothingBehind) {
  expect_error<InputError>([&] { run_gnuplot("plot nonsense(", folder_ / "a.png"); },
                           "gnuplot failed: line");
  expect_error<InputError>([&] { run_gnuplot("plot x", folder_ / "none" / "a.png"); },
                           "none/a.png: cannot be written: No such file");
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(Plots, SaysWhatToInstallWithoutGnuplot) {
  const std::string before = std::getenv("PATH");
  setenv("PATH", folder_.path().c_str(), 1);
  expect_error<InputError>([&] { run_gnuplot("plot x", folder_ / "a.png"); },
                           "install it with 'apt-get install gnuplot-nox'");
  setenv("PATH", before.c_str(), 1);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

}  // namespace
}  // namespace stillframe::report
