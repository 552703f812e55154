#include <gtest/gtest.h>

#include <Eigen/QR>
#include <limits>
#include <random>

#include "core/numerics/qd_values.hpp"
#include "core/numerics/singular_values.hpp"
#include "core/numerics/worst.hpp"
#include "tests/support/allocation_count.hpp"
#include "tests/support/quadruple.hpp"

namespace stillframe {
namespace {

using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double epsilon = std::numeric_limits<double>::epsilon();

class Random {
 public:
  MatrixXcd matrix(Index rows, Index columns) {
    return MatrixXcd::NullaryExpr(rows, columns, [&](Index, Index) {
      return std::complex<double>(normal_(engine_), normal_(engine_));
    });
  }
  MatrixXcd unitary(Index n) {
    return Eigen::HouseholderQR<MatrixXcd>(matrix(n, n)).householderQ();
  }
  VectorXd powers_of_ten(Index n, double range) {
    std::uniform_real_distribution<double> exponent(-range, 0);
    return VectorXd::NullaryExpr(n, [&](Index) { return std::pow(10, exponent(engine_)); });
  }

 private:
  std::mt19937 engine_{7};
  std::normal_distribution<double> normal_;
};

VectorXd reference(const MatrixXcd& G) {
  return test::quadruple_singular_values(test::embedded(G));
}

/// Backward stable: a few roundings a reflection, and one from either side for every row.
double rounding(const MatrixXcd& G) { return 4 * epsilon * static_cast<double>(G.size()); }

void expect_reference(const MatrixXcd& G) {
  const VectorXd values = singular_values(G), exact = reference(G);
  ASSERT_EQ(values.size(), exact.size());
  const double largest = exact.size() > 0 ? exact(0) : 0.0;
  for (Index i = 0; i < values.size(); ++i) {
    EXPECT_NEAR(values(i), exact(i), rounding(G) * largest) << "value " << i;
    if (i > 0) {
      EXPECT_LE(values(i), values(i - 1));
    }
  }
}

class Shapes : public testing::TestWithParam<std::pair<Index, Index>> {};

TEST_P(Shapes, random_matrices_against_113_bits) {
  Random random;
  for (int i = 0; i < 10; ++i) expect_reference(random.matrix(GetParam().first, GetParam().second));
}

INSTANTIATE_TEST_SUITE_P(sizes, Shapes,
                         testing::Values(std::pair{12, 12}, std::pair{6, 6}, std::pair{12, 6},
                                         std::pair{3, 8}, std::pair{1, 1}, std::pair{1, 5},
                                         std::pair{2, 2}, std::pair{7, 3}, std::pair{20, 20}));

TEST(singular_values, repeated_and_widely_spread_values) {
  Random random;
  VectorXd spread(12), repeated(12), cluster(12);
  for (Index i = 0; i < 12; ++i) {
    spread(i) = std::pow(10.0, -static_cast<double>(i));
    repeated(i) = i < 6 ? 3.0 : 0.25;
    cluster(i) = 1 + 1e-9 * static_cast<double>(i);
  }
  for (const VectorXd& values : {spread, repeated, cluster}) {
    for (int i = 0; i < 5; ++i) {
      expect_reference(random.unitary(12) * values.asDiagonal() * random.unitary(12));
    }
  }
}

TEST(singular_values, rank_deficient_and_zero) {
  Random random;
  for (Index rank = 0; rank < 12; ++rank) {
    expect_reference(random.matrix(12, rank) * random.matrix(rank, 12));
  }
  EXPECT_EQ(singular_values(MatrixXcd::Zero(6, 4)), VectorXd::Zero(4));
  MatrixXcd one_entry = MatrixXcd::Zero(5, 5);
  one_entry(3, 1) = {3.0, 4.0};
  EXPECT_NEAR(singular_values(one_entry)(0), 5.0, 5 * epsilon * 5);  // a few roundings
  EXPECT_EQ(singular_values(one_entry).tail(4), VectorXd::Zero(4));
  EXPECT_EQ(singular_values(MatrixXcd::Zero(0, 3)).size(), 0);
}

TEST(singular_values, triangular_with_ones_and_ascending_order) {
  // Bidiagonal already, and in the order that the qd algorithm likes least.
  for (const double beside : {1.0, 1e-3, 1e-8, 1e-16}) {
    MatrixXcd B = MatrixXcd::Zero(12, 12);
    for (Index i = 0; i < 12; ++i) {
      B(i, i) = std::pow(2.0, static_cast<double>(i) - 12);
      if (i < 11) B(i, i + 1) = beside;
    }
    expect_reference(B);
  }
}

TEST(singular_values, small_rows_and_columns_keep_their_digits) {
  // Scales of 1e-8 between rows or columns would cost eight digits of the small values if the error
  // were that of the largest. Three digits are allowed for what the order of rows and columns does
  // not catch; the condition of the random part is below 1e3.
  Random random;
  for (int i = 0; i < 20; ++i) {
    MatrixXcd G = random.matrix(12, 12);
    if (i % 2 == 0) {
      G.topRows(6) *= 1e-8;
    } else {
      G.leftCols(6) *= 1e-8;
    }
    const VectorXd values = singular_values(G), exact = reference(G);
    for (Index j = 0; j < 12; ++j) {
      EXPECT_NEAR(values(j) / exact(j), 1.0, 1e3 * rounding(G)) << i << " " << j;
    }
  }
}

TEST(singular_values, powers_of_two_change_nothing_but_the_scale) {
  Random random;
  const MatrixXcd G = random.matrix(12, 12);
  const VectorXd values = singular_values(G);
  for (const double scale : {0x1p-900, 0x1p-60, 0x1p60, 0x1p900}) {
    EXPECT_EQ(singular_values(scale * G), VectorXd(scale * values));
  }
}

TEST(singular_values, every_lane_is_the_same_as_alone) {
  Random random;
  std::vector<MatrixXcd> G;
  for (int i = 0; i < 11; ++i) {  // no multiple of the lanes
    G.push_back(random.matrix(12, 12) * random.powers_of_ten(12, i).asDiagonal());
  }
  G[5].setZero();
  MatrixXd values(12, 11);
  SingularValues(12, 12).compute(G.data(), 11, values);
  for (Index i = 0; i < 11; ++i) {
    // The lanes step together, so the last bits may depend on the neighbours.
    const VectorXd alone = singular_values(G[static_cast<size_t>(i)]);
    EXPECT_LE(worst_of(values.col(i) - alone), 144 * epsilon * alone(0)) << i;
  }
}

TEST(singular_values, entries_that_are_not_finite_spoil_their_matrix_only) {
  Random random;
  std::vector<MatrixXcd> G(4, random.matrix(6, 6));
  G[1](2, 3) = {0.0, std::numeric_limits<double>::quiet_NaN()};
  G[2](0, 0) = std::numeric_limits<double>::infinity();
  MatrixXd values(6, 4);
  SingularValues(6, 6).compute(G.data(), 4, values);
  EXPECT_TRUE(values.col(1).array().isNaN().all());
  EXPECT_TRUE(values.col(2).array().isNaN().all());
  EXPECT_TRUE(values.col(0).allFinite());
  EXPECT_TRUE(values.col(3).allFinite());
}

// An input along [-0.9, -0.5, 1e155] has such entries. Squares of the small ones have no inverse.
TEST(singular_values, entries_beyond_what_is_resolved_count_as_zero) {
  Random random;
  for (const double small : {1e-143, 1e-146, 1e-150, 1e-155, 1e-160, 1e-170, 1e-300}) {
    for (Index rank = 0; rank < 6; ++rank) {
      MatrixXcd G = random.matrix(6, 6), H = G;
      G.rightCols(6 - rank) *= small;
      H.rightCols(6 - rank).setZero();
      for (const MatrixXcd& turned : {G, MatrixXcd(G.transpose())}) {
        const VectorXd values = singular_values(turned);
        ASSERT_TRUE(values.allFinite()) << small << " " << rank;
        if (rank == 0) continue;  // then nothing is small beside the largest
        EXPECT_LE(worst_of(values - reference(H)), rounding(G) * values(0)) << small << " " << rank;
        EXPECT_EQ(values.tail(6 - rank), VectorXd::Zero(6 - rank)) << small << " " << rank;
      }
    }
  }
}

// What no data should bring about: it ends, and nothing that is no number passes for one.
TEST(qd_values, of_what_is_no_number_end_and_show_it) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Index n : {1, 2, 3, 7}) {
    for (Index spoilt = 0; spoilt < 2 * n - 1; ++spoilt) {
      VectorXd squares = VectorXd::Constant(2 * n - 1, 0.5), work(3 * n), values(n);
      squares(spoilt) = nan;
      qd_values(squares.data(), squares.data() + n, n, 0, work.data(), values.data());
      EXPECT_FALSE(values.allFinite()) << n << " " << spoilt;
    }
  }
}

TEST(singular_values, hot_path_allocates_nothing) {
  Random random;
  const std::vector<MatrixXcd> G(5, random.matrix(12, 6));
  SingularValues hot(12, 6);
  MatrixXd values(6, 5);
  const auto before = test::allocation_count();
  hot.compute(G.data(), 5, values);
  EXPECT_EQ(test::allocation_count(), before);
}

TEST(singular_values, refuses_negative_sizes) {
  EXPECT_THROW(SingularValues(-1, 3), std::invalid_argument);
}

}  // namespace
}  // namespace stillframe
