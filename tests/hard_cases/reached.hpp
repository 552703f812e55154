#pragma once

#include <Eigen/Core>
#include <Eigen/SVD>
#include <cstdio>

namespace stillframe::test {

/// Prints one line of the table in docs/accuracy.md.
inline void reached(const char* what, double error, double condition) {
  std::printf("[ reached  ] %-60s error %.1e  condition %.1e\n", what, error, condition);
}

inline double condition_number(const Eigen::MatrixXd& A) {
  const Eigen::VectorXd values = Eigen::JacobiSVD<Eigen::MatrixXd>(A).singularValues();
  return values(0) / values(values.size() - 1);
}

}  // namespace stillframe::test
