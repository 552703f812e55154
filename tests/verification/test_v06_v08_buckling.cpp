#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <sstream>

#include "tests/verification/closed_forms.hpp"
#include "tests/verification/convergence.hpp"
#include "tests/verification/scene_text.hpp"

// V6, V7 and V8: geometric stiffness, of buckling loads and of loaded beams.
namespace stillframe::verification {
namespace {

constexpr double pi = std::numbers::pi;

// What a cubic between the nodes leaves out of the bending energy is (k h)^4 / 720 for a wave
// number k. Without second-order terms the load works on the shortening of the chord alone, which
// leaves out (k h)^2 / 12 of it. The next terms are smaller by the order of (k h)^2, with a
// coefficient below 1/8.
double next_term(double leading, double kh) { return std::abs(leading) * kh * kh / 8; }

struct Column {
  std::string name, root, tip;
  double wave_number;  ///< pi over the buckling length
};

std::vector<Column> columns() {
  return {{"pinned", "x, y", "y", pi},
          {"clamped-free", "x, y, rotation", "", pi / 2},
          {"clamped-pinned", "x, y, rotation", "y", clamped_pinned_root()},
          {"clamped-guided", "x, y, rotation", "y, rotation", 2 * pi}};
}

std::string text_of(const Column& column) {
  const std::string text = with(without_signals(scene_text("euler_column")), "[root], fix: [x, y]",
                                "[root], fix: [" + column.root + "]");
  const std::string at_tip = "  - {nodes: [tip], fix: [y]}";
  return with(text, at_tip,
              column.tip.empty() ? "  #" : "  - {nodes: [tip], fix: [" + column.tip + "]}");
}

Error error_of(const std::string& text, double reference) {
  return [text, reference](int n) {
    const Eigen::VectorXd values = multipliers(divided(text, n));
    return values.size() > 0 ? values(0) / reference - 1 : 1.0;
  };
}

TEST(V6, EulerColumns) {
  // 0.7 L in the table stands for pi / 4.4934 = 0.69916.
  EXPECT_NEAR(pi / clamped_pinned_root(), 0.7, 1e-3);
  for (const Column& column : columns()) {
    const std::string text = text_of(column);
    const double k = column.wave_number;
    const Error second = error_of(text, k * k), first = error_of(first_order(text), k * k);
    for (const int n : {8, 16, 24}) {
      const double kh = k / n;
      const double cubic = std::pow(kh, 4) / 720, chord = kh * kh / 12;
      EXPECT_NEAR(second(n), cubic, next_term(cubic, kh) + 1e-10) << column.name << " " << n;
      EXPECT_NEAR(first(n), chord, next_term(chord, kh)) << column.name << " " << n;
    }
    EXPECT_NEAR(observed_order(second, 12), 4, 0.1);
    EXPECT_NEAR(observed_order(first, 12), 2, 0.1);
    print_counts("V6 " + column.name + ", second_order", second);
    print_counts("V6 " + column.name + ", first order", first, 1, 32);
    std::cout << "V6 " << column.name << ", first order, extrapolated: 1e-3 with "
              << extrapolated_count(first, 32, 2, 1e-3) << ", 1e-5 with "
              << extrapolated_count(first, 32, 2, 1e-5) << "\n";
  }
}

/// The counts that are extrapolated, where they are few enough to run.
TEST(V6, ExtrapolatedCountHolds) {
  const Column column = columns()[1];
  const Error first = error_of(first_order(text_of(column)), std::pow(column.wave_number, 2));
  const int n = extrapolated_count(first, 32, 2, 1e-5);
  // The error at 32 has a next term of (k h)^2 / 8 = 3e-4 of itself.
  EXPECT_LE(first(n), 1e-5 * (1 + 3e-4));
  EXPECT_GT(first(n - 2), 1e-5);
}

TEST(V6, FurtherMultipliersAreThoseOfHigherModes) {
  const Eigen::VectorXd values = multipliers(divided(text_of(columns().front()), 24));
  for (int mode = 1; mode <= 3; ++mode) {
    const double k = mode * pi, kh = k / 24, cubic = std::pow(kh, 4) / 720;
    EXPECT_NEAR(values(mode - 1) / (k * k) - 1, cubic, next_term(cubic, kh));
  }
}

/// F. Engesser, Zentralblatt der Bauverwaltung 11 (1891) 483-486: P_e / (1 + P_e / (k G A)) where
/// the normal force goes along the axis. Shear that is one value in each part leaves out (k h)^2 /
/// 12 of its share p (1 - p) of the work, p = P / (k G A); the chord the share 1 - p.
TEST(V6, ColumnsThatShearAreThoseOfEngesser) {
  const double euler = pi * pi;
  for (const double shear : {5.0, 40.0, 400.0}) {
    std::ostringstream key;
    key << "EI: 1, shear: " << shear << ",";
    const std::string text = with(text_of(columns().front()), "EI: 1,", key.str());
    const double load = euler / (1 + euler / shear), p = load / shear;
    const Error second = error_of(text, load), first = error_of(first_order(text), load);
    for (const int n : {8, 16, 32}) {
      const double kh = pi / n, chord = kh * kh / 12 * (1 - p);
      EXPECT_NEAR(second(n), chord * p + std::pow(kh, 4) / 720, next_term(chord, kh)) << shear;
      EXPECT_NEAR(first(n), chord, next_term(chord, kh)) << shear;
    }
  }
}

TEST(V7, FrequenciesOfALoadedPinnedBeam) {
  const std::string text = without_signals(scene_text("loaded_pinned_beam"));
  for (const double part : {0.5, -1.0}) {  // compression, and tension of twice the size
    const std::string loaded =
        with(text, "-194.8181820680048", number(-part * 4 * std::pow(pi, 4)));
    for (int mode = 1; mode <= 3; ++mode) {
      const double k = mode * pi, p = part / (mode * mode);
      const double reference = k * k * std::sqrt(1 - p);
      const auto error = [&](const std::string& scene) -> Error {
        return [=](int n) { return frequencies_hz(divided(scene, n))(mode - 1) / reference - 1; };
      };
      const Error second = error(loaded), first = error(first_order(loaded));
      for (const int n : {8, 16}) {
        // The relative error of the square: (k h)^4 / 720 of the unloaded one in both, and
        // p (k h)^2 / 12 of it where the load works on the chord.
        const double kh = k / n, cubic = std::pow(kh, 4) / 1440 / (1 - p),
                     chord = p * kh * kh / 24 / (1 - p);
        if (kh > 1.2) continue;
        EXPECT_NEAR(second(n), cubic, next_term(cubic, kh) + 1e-9) << mode << " " << n;
        EXPECT_NEAR(first(n), chord + cubic, next_term(std::abs(chord) + cubic, kh))
            << mode << " " << n;
      }
      if (part > 0) {
        EXPECT_NEAR(observed_order(second, 8), 4, 0.1) << mode;
        const std::string name = "V7 mode " + std::to_string(mode);
        print_counts(name + ", second_order", second, mode);
        print_counts(name + ", first order", first, mode, 32);
        std::cout << name << ", first order, extrapolated: 1e-3 with "
                  << extrapolated_count(first, 32, 2, 1e-3) << ", 1e-5 with "
                  << extrapolated_count(first, 32, 2, 1e-5) << "\n";
      }
    }
  }
}

TEST(V7, FirstFrequencyGoesToZeroWithTheSquareRootOfTheDistance) {
  const std::string text = divided(without_signals(scene_text("loaded_pinned_beam")), 16);
  // The model's own buckling load, so that 1 - p keeps its digits.
  const double P = multipliers(with(text, "-194.8181820680048", "-1"))(0);
  for (const double p : {0.9, 0.99, 0.9999}) {
    const double f =
        frequencies_hz(with(text, "-194.8181820680048", number(-p * P)))(0) / (pi * pi);
    // (k h)^4 / 720 = 2e-6 in the mass matrix, and rounding of 1e-11 over 1 - p.
    EXPECT_NEAR(f / std::sqrt(1 - p), 1, 5e-6) << p;
  }
}

/// Twist is interpolated linearly, which is of the second order in h however the bending is taken.
/// The scene has the very load of Ritz's method with cubic deflection and linear twist.
TEST(V8, LateralBucklingIsThatOfRitzWithTheSameFunctions) {
  const double reference = lateral_buckling_load();
  EXPECT_NEAR(reference, 4.012599, 5e-7);  // half a unit of the last digit of the table
  const std::string text = without_signals(scene_text("lateral_buckling"));
  const Error second = error_of(text, reference), first = error_of(first_order(text), reference);
  for (const int n : {1, 2, 4, 8, 16}) {
    // The buckling load is a ratio of numbers that differ by EI_y / EI_z = 1e4 and EA / EI_z = 1e6:
    // rounding of 1e-16 times 1e6, and n^2 for the condition of the stiffness.
    const double ritz = lateral_buckling_by_ritz(n);
    EXPECT_NEAR(multipliers(divided(text, n))(0) / ritz, 1, 1e-10 * n * n) << n;
  }
  EXPECT_NEAR(observed_order(second, 8), 2, 0.1);
  EXPECT_NEAR(observed_order(first, 8), 2, 0.1);
  EXPECT_GT(first(16) / second(16), 2);  // the second-order terms take off two thirds of the error
  print_counts("V8 second_order", second, 1, 40);
  print_counts("V8 first order", first, 2, 40);
  for (const auto& [name, error] : {std::pair{"second_order", second}, {"first order", first}}) {
    std::cout << "V8 " << name << ", extrapolated: 1e-3 with "
              << extrapolated_count(error, 32, 2, 1e-3) << ", 1e-5 with "
              << extrapolated_count(error, 32, 2, 1e-5) << "\n";
  }
}

}  // namespace
}  // namespace stillframe::verification
