#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "core/mechanics/linearisation/linearisation.hpp"
#include "core/systems/state_space_model.hpp"
#include "tools/json.hpp"

namespace stillframe::tools {

/// One column of B and D: of which input, what of it ("direct", or "acceleration", "velocity" or
/// "position" of a prescribed motion) and in which unit.
struct ColumnInfo {
  std::string input, of, unit;
};
std::vector<ColumnInfo> columns_of(const StateSpace& system);

/// "direct", "acceleration", "velocity", "position".
const char* word(InputColumns::Kind kind);

/// The matrices of the second-order form with their names, in the order of LinearModel.
using NamedMatrix = std::pair<const char*, const Eigen::MatrixXd*>;
std::vector<NamedMatrix> second_order_matrices(const LinearModel& model);

/// Keys of a linear model that `linearise --json` prints; `stillframe linearise --help` lists them.
Json to_json(const LinearModel& model, const StateSpace& system);

/// Writes it for MATLAB and Octave, the six matrices as M_bar, C_bar, ... Errors: InputError.
void write_mat(const LinearModel& model, const StateSpace& system,
               const std::filesystem::path& file);

}  // namespace stillframe::tools
