#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace stillframe::report {

struct MatValue;
using MatValues = std::map<std::string, MatValue>;

/// A variable of a .mat file that is none of the kinds below; `what` names its kind.
struct MatOther {
  std::string what;
};

/// What a variable or a field holds: real numbers of any class as a matrix of doubles, texts (a row
/// of letters, or a cell array or several rows of them), or one structure.
struct MatValue {
  std::variant<Eigen::MatrixXd, std::vector<std::string>, MatValues, MatOther> is;
};

/// The variables of a MATLAB level-5 file, compressed or not, as MATLAB and Octave write it with
/// -v6 and -v7. bytes: of the file; source_name stands for it in messages. Nothing that the bytes
/// say of themselves is believed. Set-up. Errors: InputError of what is no such file, ends early,
/// or would take more than 64 MiB. Source: The MathWorks, MAT-File Format, "Level 5 MAT-File
/// Format".
MatValues read_mat(std::string_view bytes, const std::string& source_name);

}  // namespace stillframe::report
