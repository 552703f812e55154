#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/faults/episodes.hpp"

namespace stillframe::faults {

/// What is wrong with a row, one line each; empty if it is as it should be. An episode that the
/// machine disturbed is only asked to recover without a latched fault, and to keep twice its ratio.
std::vector<std::string> failures(const KindResult& result);

/// The rows as a table in Markdown ("disturbed": the machine itself was late meanwhile), and as
/// JSON: name, allowed, exit_code, trouble, and for every
/// episode seed, outcome, recovery_samples, over_passive, over_minute, over_same_samples,
/// over_left, model_error, disturbed, n_inflicted, n_counted and n_at_most.
std::string markdown(const std::vector<KindResult>& results);
nlohmann::json to_json(const std::vector<KindResult>& results);

}  // namespace stillframe::faults
