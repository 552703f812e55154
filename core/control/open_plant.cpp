#include "core/control/open_plant.hpp"

namespace stillframe {

using Eigen::Index;
using Eigen::MatrixXd;

LinearSystem open_plant(const SampledPlant& plant) {
  const Index n = plant.Phi.rows(), m = plant.Gamma_u.cols(), p = plant.Gamma_w.cols(),
              n_y = plant.C_y.rows();
  // Behind the plant: the floor as it was measured last, c_0, the reports and the commands on their
  // way, each of these leg by leg and oldest first.
  const Index floor = n, held = floor + p, reports = held + m,
              pending = reports + m * plant.report_age, total = pending + plant.whole_delay.sum();
  LinearSystem out{.A = MatrixXd::Zero(total, total),
                   .B = MatrixXd::Zero(total, p + m),
                   .C = MatrixXd::Zero(n_y + 2 * m + p, total),
                   .D = MatrixXd::Zero(n_y + 2 * m + p, p + m)};
  // c_1, what takes effect in the coming interval, over states and u.
  MatrixXd c_x = MatrixXd::Zero(m, total), c_u = MatrixXd::Zero(m, m);
  Index queue = pending;
  for (Index i = 0; i < m; ++i) {
    const Index n_waiting = plant.whole_delay(i);
    if (n_waiting == 0) {
      c_u(i, i) = 1;
      continue;
    }
    c_x(i, queue) = 1;
    for (Index j = 0; j + 1 < n_waiting; ++j) out.A(queue + j, queue + j + 1) = 1;
    out.B(queue + n_waiting - 1, p + i) = 1;
    queue += n_waiting;
  }
  MatrixXd report = MatrixXd::Zero(m, total);
  report.leftCols(n) = plant.C_report;
  report.middleCols(held, m) = plant.D_report;

  out.A.topRows(n) = plant.Gamma_u * c_x;
  out.A.topLeftCorner(n, n) += plant.Phi;
  out.A.block(0, held, n, m) += plant.Gamma_0;
  out.A.middleRows(held, m) = c_x;
  out.B.topLeftCorner(n, p) = plant.Gamma_w;
  out.B.topRightCorner(n, m) = plant.Gamma_u * c_u;
  out.B.block(floor, 0, p, p).setIdentity();
  out.B.block(held, p, m, m) = c_u;
  for (Index i = 0; i < plant.report_age; ++i) {
    const Index row = reports + m * i;
    if (i + 1 < plant.report_age) {
      out.A.block(row, row + m, m, m).setIdentity();
    } else {
      out.A.middleRows(row, m) = report;
    }
  }

  out.C.topRows(n_y) = plant.D_yu * c_x;
  out.C.topLeftCorner(n_y, n) += plant.C_y;
  out.C.block(0, held, n_y, m) += plant.D_0;
  out.D.topLeftCorner(n_y, p) = plant.D_yw;
  out.D.topRightCorner(n_y, m) = plant.D_yu * c_u;
  out.C.block(n_y, 0, m, n) = plant.C_sigma;
  out.C.block(n_y, held, m, m) = plant.D_sigma;
  if (plant.report_age > 0) {
    out.C.block(n_y + m, reports, m, m).setIdentity();
  } else {
    out.C.middleRows(n_y + m, m) = report;
  }
  out.C.block(n_y + 2 * m, floor, p, p).setIdentity();
  return out;
}

}  // namespace stillframe
