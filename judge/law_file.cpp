#include "judge/law_file.hpp"

#include <filesystem>

#include "controller/law_block.hpp"
#include "core/errors/input_error.hpp"
#include "core/yaml/loop_numbers.hpp"
#include "core/yaml/ranges.hpp"
#include "report/export/mat_reader.hpp"

namespace stillframe::judge {

using Eigen::Index;
using Eigen::MatrixXd;
using report::MatOther;
using report::MatValue;
using report::MatValues;

namespace {

LawFile from_yaml(const std::string& name, const std::string& bytes) {
  const YamlReader reader = YamlReader::from_text(bytes, name);
  reader.allow_only({"sample_rate_hz", "inputs", "outputs", "A", "B", "C", "D", "K_P", "K_I"});
  LawFile file;
  if (const auto rate = reader.find("sample_rate_hz")) {
    file.sample_rate_hz = number_within(*rate, lowest_rate_hz, highest_rate_hz);
  }
  const auto K_P = reader.find("K_P"), K_I = reader.find("K_I");
  if (!K_P && !K_I) {
    reader.require("sample_rate_hz");
    file.law = controller::read_law_block(reader);
    return file;
  }
  for (const char* key : {"inputs", "outputs", "A", "B", "C", "D"}) {
    const auto found = reader.find(key);
    if (found) found->fail("allowed is either A, B, C, D or K_P, K_I");
  }
  const Index m = std::ssize(reader.require("K_P").items());
  file.K_P = reader.require("K_P").matrix(m, m, largest_entry);
  file.K_I = reader.require("K_I").matrix(m, m, largest_entry);
  return file;
}

/// The variables of a file, or the fields of its structure `law`.
class Scope {
 public:
  Scope(std::string name, const MatValues& values) : name_(std::move(name)), values_(values) {}

  bool has(const char* key) const { return values_.contains(key); }

  MatrixXd matrix(const char* key) const {
    const MatValue& value = at(key);
    const auto* matrix = std::get_if<MatrixXd>(&value.is);
    if (matrix == nullptr) fail(key, value, "a matrix of real numbers");
    // Written so that NaN is refused as well.
    if (!(matrix->size() == 0 || matrix->cwiseAbs().maxCoeff() <= largest_entry) ||
        !matrix->allFinite()) {
      throw InputError(name_ + ": " + key + ": found a number that is not finite or beyond " +
                       shortest_digits(largest_entry));
    }
    return *matrix;
  }

  double number(const char* key) const {
    const MatrixXd value = matrix(key);
    if (value.size() != 1) {
      throw InputError(name_ + ": " + key + ": found a matrix of " + std::to_string(value.rows()) +
                       " x " + std::to_string(value.cols()) + ", allowed is one number");
    }
    return value(0);
  }

  std::vector<std::string> texts(const char* key) const {
    const MatValue& value = at(key);
    const auto* texts = std::get_if<std::vector<std::string>>(&value.is);
    if (texts == nullptr) fail(key, value, "texts (a cell array of them)");
    return *texts;
  }

 private:
  const MatValue& at(const char* key) const {
    const auto found = values_.find(key);
    if (found == values_.end()) {
      throw InputError(name_ + ": " + key +
                       ": is missing; a law has A, B, C, D, Ts, input_names and output_names, or "
                       "K_P and K_I");
    }
    return found->second;
  }

  [[noreturn]] void fail(const char* key, const MatValue& value, const char* allowed) const {
    std::string found = "a matrix";
    if (const auto* other = std::get_if<MatOther>(&value.is)) found = other->what;
    if (std::holds_alternative<std::vector<std::string>>(value.is)) found = "texts";
    if (std::holds_alternative<MatValues>(value.is)) found = "a structure";
    throw InputError(name_ + ": " + key + ": found " + found + ", allowed is " + allowed);
  }

  std::string name_;
  const MatValues& values_;
};

LawFile from_mat(const std::string& name, const std::string& bytes) {
  const MatValues all = report::read_mat(bytes, name);
  const auto structure = all.find("law");
  const auto* fields =
      structure == all.end() ? nullptr : std::get_if<MatValues>(&structure->second.is);
  const Scope scope = fields != nullptr ? Scope(name + ": law", *fields) : Scope(name, all);
  LawFile file;
  if (scope.has("Ts")) {
    const double sample_time = scope.number("Ts");
    if (!(sample_time >= 1 / highest_rate_hz && sample_time <= 1 / lowest_rate_hz)) {
      throw InputError(name + ": Ts: found " + shortest_digits(sample_time) + " s, allowed is " +
                       shortest_digits(1 / highest_rate_hz) + " to " +
                       shortest_digits(1 / lowest_rate_hz) +
                       ": a law is one in discrete time (c2d makes it one)");
    }
    file.sample_rate_hz = 1 / sample_time;
  }
  const bool gains = scope.has("K_P") || scope.has("K_I");
  if (!gains || scope.has("A")) {
    if (gains) throw InputError(name + ": allowed is either A, B, C, D or K_P, K_I");
    file.law = NamedLaw{.inputs = scope.texts("input_names"),
                        .outputs = scope.texts("output_names"),
                        .A = scope.matrix("A"),
                        .B = scope.matrix("B"),
                        .C = scope.matrix("C"),
                        .D = scope.matrix("D")};
    scope.number("Ts");
    // Of no states MATLAB and Octave keep no shape.
    NamedLaw& law = *file.law;
    if (law.A.size() == 0 && law.B.size() == 0 && law.C.size() == 0) {
      law.A.resize(0, 0);
      law.B.resize(0, std::ssize(law.inputs));
      law.C.resize(std::ssize(law.outputs), 0);
    }
    return file;
  }
  file.K_P = scope.matrix("K_P");
  file.K_I = scope.matrix("K_I");
  return file;
}

}  // namespace

LawFile read_law_file(const std::string& name, const std::string& bytes) {
  const std::string ending = std::filesystem::path(name).extension().string();
  if (ending == ".mat") return from_mat(name, bytes);
  if (ending == ".yaml" || ending == ".yml") return from_yaml(name, bytes);
  throw InputError(name + ": law: found a name that ends on \"" + ending +
                   "\", allowed are .mat, .yaml and .yml");
}

}  // namespace stillframe::judge
