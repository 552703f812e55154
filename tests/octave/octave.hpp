#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <map>
#include <string>

namespace stillframe::octave {

/// What Octave is given about one case, and what it answers, by name.
using Given = std::map<std::string, Eigen::MatrixXd>;
using Answer = std::map<std::string, Eigen::MatrixXcd>;

/// Why there is no answer, or nothing.
struct Outcome {
  std::string missing;  ///< what is not installed
  std::string failure;  ///< what Octave said when it failed
  std::map<std::string, Answer> answers;
};

/// Runs control_package.m once over all cases, in a folder that it makes and takes away again.
Outcome ask(const std::map<std::string, Given>& cases);

}  // namespace stillframe::octave
