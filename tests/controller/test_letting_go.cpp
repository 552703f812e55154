#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <fstream>
#include <numbers>
#include <sstream>
#include <string>

#include "controller/policy.hpp"
#include "core/numerics/smooth_step.hpp"
#include "core/numerics/worst.hpp"

// The figures of docs/safety.md on why everything lets go smoothly.
namespace stillframe::controller {
namespace {

/// What a mode that turns by `angle` (rad) during the fade swings with afterwards, over what it
/// would swing with after a step: the Fourier integral of the derivative of the curve.
double left_swinging(double angle) {
  constexpr int n = 20000;  // of a midpoint rule, whose error is below 1e-8 for these angles
  std::complex<double> sum = 0;
  for (int i = 0; i < n; ++i) {
    const double low = double(i) / n, high = double(i + 1) / n;
    sum += (smooth_step(high) - smooth_step(low)) * std::polar(1.0, -angle * (low + high) / 2);
  }
  return std::abs(sum);
}

/// The largest second derivative of the curve.
double largest_curvature() {
  constexpr double h = 1e-4;  // the differences are then good to 1e-6
  double largest = 0;
  for (double p = h; p < 1 - h; p += h) {
    const double second = (smooth_step(p + h) - 2 * smooth_step(p) + smooth_step(p - h)) / (h * h);
    largest = worst_of(largest, std::abs(second));
  }
  return largest;
}

std::string digits(const char* format, double value) {
  char text[32];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

TEST(LettingGo, TheBoundOnWhatIsLeftSwingingHolds) {
  double largest = 0;
  for (double angle = 80; angle < 400; angle += 0.37) {
    largest = worst_of(largest, left_swinging(angle) * std::pow(angle, 3));
  }
  EXPECT_LE(largest, 120.4);  // the next term is 6 / angle of it in quadrature: 0.3 % at 80 rad
  EXPECT_GE(largest, 119);    // and the bound is reached
}

TEST(LettingGo, TheFiguresOfTheTextAreThoseOfTheFormulas) {
  constexpr double target_hz = 5, lowest_hz = 13.9055, highest_hz = 49.0032;
  const double two_pi = 2 * std::numbers::pi, fade_s = Policy{}.fade_s;
  const double kick_low = std::pow(lowest_hz / target_hz, 2);
  const double kick_high = std::pow(highest_hz / target_hz, 2);
  const double left = 120 / std::pow(two_pi * lowest_hz * fade_s, 3);
  const double curvature = largest_curvature();
  const double on_the_way = curvature / std::pow(two_pi * target_hz * fade_s, 2);

  std::ifstream file(STILLFRAME_SOURCE_DIR "/docs/safety.md");
  std::stringstream stream;
  stream << file.rdbuf();
  std::string text = stream.str();
  for (char& c : text) c = c == '\n' ? ' ' : c;
  const auto says = [&text](const std::string& words) {
    EXPECT_NE(text.find(words), std::string::npos) << "not in the text: " << words;
  };
  says("that is " + digits("%.0f", kick_low) + " times the floor's acceleration");
  says("and " + digits("%.0f", kick_high) + " times for that at 49 Hz");
  says(digits("%.3f", 100 * left) + " % of it at 13.9 Hz");
  says(digits("%.2f", 100 * left * kick_low) + " % of the floor's acceleration");
  says("at most " + digits("%.1f", curvature) +
       " / (ω_d t)² = " + digits("%.1f", 100 * on_the_way) + " % of a_floor");
}

}  // namespace
}  // namespace stillframe::controller
