#pragma once

#include "tests/design_cases/simulation.hpp"

// What is predicted of a case against what the nonlinear plant does.
namespace stillframe::test {

/// A case that is predicted to be stable: it calms down within `seconds` after a kick, and T is the
/// predicted one at 10, 20 and 50 Hz, all six singular values.
void expect_stable_as_predicted(const Case& made, double seconds = 2);

/// A case that is predicted to be unstable: it runs away at the rate of its worst pole.
void expect_unstable_as_predicted(const Case& made, double relative_tolerance, double seconds = 2);

}  // namespace stillframe::test
