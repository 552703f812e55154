// How time and memory grow with a chain of spatial beams, all of them flexible: the model, its
// linearisation, its state matrix and its natural frequencies, for both choices of dofs.
#include <sys/resource.h>

#include <Eigen/Eigenvalues>
#include <chrono>
#include <cmath>
#include <iostream>

#include "bench/chain_of_beams.hpp"
#include "bench/machine.hpp"
#include "core/errors/formatted.hpp"
#include "core/mechanics/linearisation/linearisation.hpp"
#include "core/mechanics/operating_point.hpp"
#include "core/mechanics/state_space.hpp"
#include "report/table.hpp"

namespace {

using namespace stillframe;

struct Times {
  double model, linearise, A, frequencies;
  double first_error;  ///< of the lowest natural frequency
  double total() const { return model + linearise + A + frequencies; }
};

template <class F>
double seconds(const F& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Times measure(int n, bool by_deformations) {
  const Scene scene = chain_of_beams(n, by_deformations);
  Times t{};
  std::unique_ptr<Model> model;
  LinearModel linear;
  t.model = seconds([&] { model = std::make_unique<Model>(make_model(scene)); });
  t.linearise = seconds([&] { linear = linearise(*model, scene.inputs, scene.outputs); });
  t.A = seconds([&] { state_matrix(linear); });
  double lowest = 0;
  t.frequencies = seconds([&] {
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(
        linear.stiffness(), linear.M, Eigen::EigenvaluesOnly);
    lowest = std::sqrt(solver.eigenvalues()(0));
  });
  t.first_error = std::abs(lowest / 3.516015269 - 1);
  return t;
}

}  // namespace

int main() {
  using stillframe::formatted;
  std::cout << "# " << stillframe::machine_line(STILLFRAME_FLAGS) << "\n";
  for (const bool by_deformations : {false, true}) {
    stillframe::report::Table table({"beams", "dofs", "model s", "linearise s", "A s",
                                     "frequencies s", "all s", "exponent", "error of first"},
                                    0);
    double last_total = 0;
    int last = 0;
    for (const int n : {10, 30, 100, 300}) {
      std::cerr << "chain of " << n << " beams ...\n";
      const Times t = measure(n, by_deformations);
      const double exponent =
          last ? std::log(t.total() / last_total) / std::log(double(n) / last) : 0;
      table.add({formatted("%d", n), formatted("%d", 6 * n), formatted("%.4f", t.model),
                 formatted("%.4f", t.linearise), formatted("%.4f", t.A),
                 formatted("%.4f", t.frequencies), formatted("%.3f", t.total()),
                 last ? formatted("%.2f", exponent) : "", formatted("%.1e", t.first_error)});
      last = n;
      last_total = t.total();
    }
    std::cout << (by_deformations ? "dofs: deformations\n" : "dofs: nodal coordinates (auto)\n")
              << table.print() << "\n";
  }
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::cout << "largest memory: " << usage.ru_maxrss / 1024 << " MiB\n";
}
