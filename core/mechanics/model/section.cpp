#include "core/mechanics/model/section.hpp"

namespace stillframe {

namespace {

double ratio(double EI, double shear, double l_0) {
  return shear > 0 ? 12 * EI / (shear * l_0 * l_0) : 0.0;
}

Eigen::Matrix2d bending(double EI, double Phi, double l_0) {
  Eigen::Matrix2d block;
  block << 4 + Phi, Phi - 2, Phi - 2, 4 + Phi;
  return EI / ((1 + Phi) * l_0 * l_0 * l_0) * block;
}

}  // namespace

double shear_ratio_y(const SceneBeam& section, double l_0) {
  return ratio(section.EI_z, section.shear_y, l_0);
}

double shear_ratio_z(const SceneBeam& section, double l_0) {
  return ratio(section.EI_y, section.shear_z, l_0);
}

LocalStiffness section_stiffness(const SceneBeam& section, double l_0, bool planar) {
  const Eigen::Index n = planar ? 3 : 6;
  LocalStiffness S = LocalStiffness::Zero(n, n);
  S(0, 0) = section.EA / l_0;
  if (planar) {
    S.block<2, 2>(1, 1) = bending(section.EI_z, shear_ratio_y(section, l_0), l_0);
    return S;
  }
  S(1, 1) = section.GJ / (l_0 * l_0 * l_0);
  // Deflection along n_z bends about n_y.
  S.block<2, 2>(2, 2) = bending(section.EI_y, shear_ratio_z(section, l_0), l_0);
  S.block<2, 2>(4, 4) = bending(section.EI_z, shear_ratio_y(section, l_0), l_0);
  return S;
}

}  // namespace stillframe
