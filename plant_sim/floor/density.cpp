#include "plant_sim/floor/density.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/numerics/two_pi.hpp"

namespace stillframe::floor {

namespace {

/// From a period on, PSD = a + b log10(period) dB re 1 (m/s^2)^2/Hz.
struct PetersonRow {
  double period_s, a, b;
};

constexpr double longest_period_s = 1e5;

constexpr std::array<PetersonRow, 21> low_noise = {
    {{0.1, -162.36, 5.64},   {0.17, -166.7, 0},       {0.4, -170, -8.3},    {0.8, -166.4, 28.9},
     {1.24, -168.6, 52.48},  {2.4, -159.98, 29.81},   {4.3, -141.1, 0},     {5, -71.36, -99.77},
     {6, -97.26, -66.49},    {10, -132.18, -31.57},   {12, -205.27, 36.16}, {15.6, -37.65, -104.33},
     {21.9, -114.37, -47.1}, {31.6, -160.58, -16.28}, {45, -187.5, 0},      {70, -216.47, 15.7},
     {101, -185, 0},         {154, -168.34, -7.61},   {328, -217.43, 11.9}, {600, -258.28, 26.6},
     {10000, -346.88, 48.75}}};

constexpr std::array<PetersonRow, 11> high_noise = {{{0.1, -108.73, -17.23},
                                                     {0.22, -150.34, -80.5},
                                                     {0.32, -122.31, -23.87},
                                                     {0.8, -116.85, 32.51},
                                                     {3.8, -108.48, 18.08},
                                                     {4.6, -74.66, -32.95},
                                                     {6.3, 0.66, -127.18},
                                                     {7.9, -93.37, -22.42},
                                                     {15.4, 73.54, -162.98},
                                                     {20, -151.52, 10.01},
                                                     {354.8, -206.66, 31.63}}};

template <std::size_t n>
double peterson(const std::array<PetersonRow, n>& rows, double frequency_hz) {
  const double period = 1.0 / frequency_hz;
  if (period < rows.front().period_s || period > longest_period_s) return 0.0;
  const auto next =
      std::upper_bound(rows.begin(), rows.end(), period,
                       [](double value, const PetersonRow& row) { return value < row.period_s; });
  const PetersonRow& row = *std::prev(next);
  return std::pow(10.0, 0.1 * (row.a + row.b * std::log10(period)));
}

double at(const PetersonDensity& model, double f) {
  return model.high ? peterson(high_noise, f) : peterson(low_noise, f);
}

double at(const VibrationCriterionDensity& criterion, double f) {
  // The edges of the bands at 1 and 80 Hz (10^0 and 10^1.9 Hz).
  if (f < std::pow(10.0, -0.05) || f > std::pow(10.0, 1.95)) return 0.0;
  const double band = std::numbers::ln10 / 10.0, v = criterion_velocity(criterion.letter);
  // The band at 8 Hz, whose lower edge is 10^0.85 Hz, belongs to the flat part.
  const bool relaxed = criterion.letter <= 'B' && f < std::pow(10.0, 0.85);
  if (relaxed) return std::pow(two_pi * 8.0 * v, 2) / (f * std::sinh(band));
  return two_pi * two_pi * v * v * f / band;
}

double at(const PointsDensity& line, double f) {
  const auto& points = line.points;
  if (points.empty() || f < points.front().first || f > points.back().first) return 0.0;
  auto above =
      std::lower_bound(points.begin(), points.end(), f,
                       [](const auto& point, double value) { return point.first < value; });
  if (above == points.begin()) return above->second;
  const auto below = std::prev(above);
  const double part = std::log(f / below->first) / std::log(above->first / below->first);
  return below->second * std::pow(above->second / below->second, part);
}

}  // namespace

double criterion_velocity(char letter) {
  constexpr std::array<double, 7> velocities = {50e-6,   25e-6,   12.5e-6, 6.25e-6,
                                                3.12e-6, 1.56e-6, 0.78e-6};
  return velocities.at(criterion_letters.find(letter));
}

double density_at(const Density& density, double frequency_hz) {
  return std::visit([&](const auto& shape) { return at(shape, frequency_hz); }, density);
}

}  // namespace stillframe::floor
