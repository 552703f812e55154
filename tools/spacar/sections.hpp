#pragma once

#include <string>
#include <vector>

namespace stillframe::tools::spacar {

/// A cross-section of SPACAR Light, with its material.
struct Section {
  bool circular = false;
  double width = 0;      ///< along y', m; the diameter of a circular one
  double thickness = 0;  ///< along z', m
  double e_modulus = 0, g_modulus = 0, density = 0;
};

/// What an area of one material resists with, as ESTIFF has it: EA (N), G J (N m^2), E I_y, E I_z
/// (N m^2), and E I_y / (k G A), E I_z / (k G A) (m^2). I is of Euler and Bernoulli, J Saint
/// Venant's series for a rectangle, k Cowper's for a rectangle 10 (1 + v) / (12 + 11 v), for a
/// circle 6 (1 + v) / (7 + 6 v), v = E / (2 G) - 1 (G. R. Cowper, The shear coefficient in
/// Timoshenko's beam theory, J. Appl. Mech. 33, 1966).
std::vector<double> section_stiffness(const Section& section);

/// Per length, as EM has it: mass (kg/m), and rotary inertia about x', y' and z' (kg m).
std::vector<double> section_inertia(const Section& section);

/// Saint Venant's torsion constant of a rectangle, m^4 (Timoshenko and Goodier, Theory of
/// Elasticity, article 109).
double rectangle_torsion_constant(double a, double b);

/// Vlasov's warping stiffness of a strip, E w^3 t^3 / 144 (N m^4); 0 of a circle, which does not
/// warp.
double section_warping(const Section& section);

/// By how much a beam twists less because its ends cannot warp: G J theta' - E I_w theta''' = T
/// over a length L with one end held against warping, or both. 1 without ends or without E I_w.
double warping_factor(double torsion, double warping, double length, int n_held_ends);

/// What to say of a strip that is divided: a factor of each of its beams cannot have the stiffness
/// by which two halves hold each other.
inline constexpr const char* into_neighbour =
    "; that warping goes on into its neighbour is left out, and torsion of what lies between is "
    "too "
    "soft";

}  // namespace stillframe::tools::spacar
