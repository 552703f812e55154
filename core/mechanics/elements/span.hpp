#pragma once

#include <Eigen/Core>
#include <cmath>

namespace stillframe {

/// The vector between two points of an element and the elongation e = l - l_0 with its derivatives.
/// e is written as (l^2 - l_0^2) / (l + l_0) with l^2 - l_0^2 = (2 l_0 + d) . d, d = u_q - u_p, so
/// that a picometre survives on a metre (THEORY section 2). hot: noexcept, no allocation.
struct Span {
  Eigen::Vector3d l_vector, direction;
  double length = 0, elongation = 0;

  Span(const Eigen::Vector3d& l_0_vector, double l_0, const Eigen::Vector3d& d) noexcept
      : l_vector(l_0_vector + d) {
    length = l_vector.norm();
    direction = l_vector / length;
    elongation = (2.0 * l_0_vector + d).dot(d) / (length + l_0);
  }
  /// d2 l (v, w) for two differences of end displacements.
  double second(const Eigen::Vector3d& v, const Eigen::Vector3d& w) const noexcept {
    return (v.dot(w) - direction.dot(v) * direction.dot(w)) / length;
  }
  /// First and second time derivatives of the direction while d' = v and d'' = a.
  struct DirectionRates {
    Eigen::Vector3d first, second;
  };
  DirectionRates direction_rates(const Eigen::Vector3d& v,
                                 const Eigen::Vector3d& a) const noexcept {
    DirectionRates rates;
    const double length_rate = direction.dot(v);
    rates.first = (v - length_rate * direction) / length;
    const double length_second = direction.dot(a) + rates.first.dot(v);
    rates.second = (a - length_second * direction - 2.0 * length_rate * rates.first) / length;
    return rates;
  }
  /// d2 l / dd dd, 3 x 3.
  Eigen::Matrix3d curvature() const noexcept {
    return (Eigen::Matrix3d::Identity() - direction * direction.transpose()) / length;
  }
};

}  // namespace stillframe
