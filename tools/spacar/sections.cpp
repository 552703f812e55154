#include "tools/spacar/sections.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stillframe::tools::spacar {

namespace {

struct Areas {
  double A, J, I_y, I_z, k;
};

Areas areas_of(const Section& section) {
  constexpr double pi = std::numbers::pi;
  const double poisson = section.e_modulus / (2 * section.g_modulus) - 1;
  if (section.circular) {
    const double d = section.width, I = pi / 64 * std::pow(d, 4);
    return {.A = pi / 4 * d * d,
            .J = 2 * I,
            .I_y = I,
            .I_z = I,
            .k = 6 * (1 + poisson) / (7 + 6 * poisson)};
  }
  const double w = section.width, t = section.thickness;
  return {.A = w * t,
          .J = rectangle_torsion_constant(w, t),
          .I_y = w * t * t * t / 12,
          .I_z = t * w * w * w / 12,
          .k = 10 * (1 + poisson) / (12 + 11 * poisson)};
}

}  // namespace

double rectangle_torsion_constant(double a, double b) {
  constexpr double pi = std::numbers::pi;
  const double longer = std::max(a, b), shorter = std::min(a, b);
  double sum = 0;
  // The terms fall as n^-5: at n = 99 they are below 1e-10 of the first.
  for (int n = 99; n >= 1; n -= 2) {
    sum += std::tanh(n * pi * longer / (2 * shorter)) / std::pow(n, 5);
  }
  return longer * std::pow(shorter, 3) / 3 * (1 - 192 / std::pow(pi, 5) * (shorter / longer) * sum);
}

std::vector<double> section_stiffness(const Section& section) {
  const Areas a = areas_of(section);
  const double E = section.e_modulus, G = section.g_modulus, shear = a.k * G * a.A;
  return {E * a.A, G * a.J, E * a.I_y, E * a.I_z, E * a.I_y / shear, E * a.I_z / shear};
}

std::vector<double> section_inertia(const Section& section) {
  const Areas a = areas_of(section);
  const double rho = section.density;
  return {rho * a.A, rho * (a.I_y + a.I_z), rho * a.I_y, rho * a.I_z};
}

double section_warping(const Section& section) {
  if (section.circular) return 0;
  return section.e_modulus * std::pow(section.width * section.thickness, 3) / 144;
}

double warping_factor(double torsion, double warping, double length, int n_held_ends) {
  if (n_held_ends == 0 || !(warping > 0) || !(torsion > 0)) return 1;
  // Held at both ends a beam is two of half its length, each held at one.
  const double kappa = length * std::sqrt(torsion / warping) / n_held_ends;
  return 1 / (1 - std::tanh(kappa) / kappa);
}

}  // namespace stillframe::tools::spacar
