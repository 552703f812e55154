#pragma once

#include "controller/gains.hpp"

namespace stillframe::fuzz {

/// Whether the loop of these gains, stepped by the law that runs and the sampled plant of the file
/// from a state that has something of every mode, is no larger after 100 000 samples than half way.
/// A second way to the judgement: it uses neither close_loop nor eigenvalues.
bool decays(const controller::Gains& gains);

}  // namespace stillframe::fuzz
