#include "tests/octave/octave.hpp"

#include <sys/wait.h>

#include <complex>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "tests/support/scratch_folder.hpp"

namespace stillframe::octave {

namespace fs = std::filesystem;
using Eigen::Index;
using Eigen::MatrixXcd;
using Eigen::MatrixXd;

namespace {

/// Exit code of a shell that finds no such program, and that of the script without its package.
constexpr int no_program = 127, no_package = 77;

/// Octave's own text format; 17 digits give back the same bits.
void write(const fs::path& file, const Given& given) {
  std::ofstream out(file);
  out.precision(17);
  for (const auto& [name, matrix] : given) {
    out << "# name: " << name << '\n';
    if (matrix.size() == 1) {  // not a number to the control package if written as a matrix
      out << "# type: scalar\n" << matrix(0) << '\n';
      continue;
    }
    out << "# type: matrix\n# rows: " << matrix.rows() << "\n# columns: " << matrix.cols() << '\n';
    for (Index i = 0; i < matrix.rows(); ++i) {
      for (Index j = 0; j < matrix.cols(); ++j) out << ' ' << matrix(i, j);
      out << '\n';
    }
  }
}

/// Lines of name, rows, columns, then real and imaginary parts column by column.
Answer read(const fs::path& file) {
  std::ifstream in(file);
  Answer answer;
  std::string name;
  Index rows = 0, columns = 0;
  while (in >> name >> rows >> columns) {
    MatrixXcd& matrix = answer[name];
    matrix.resize(rows, columns);
    for (Index i = 0; i < matrix.size(); ++i) {
      std::string re, im;  // a stream does not read inf and nan as numbers
      if (!(in >> re >> im)) throw std::runtime_error(file.string() + ": '" + name + "' is short");
      matrix(i) = {std::strtod(re.c_str(), nullptr), std::strtod(im.c_str(), nullptr)};
    }
  }
  return answer;
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file);
  std::stringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace

Outcome ask(const std::map<std::string, Given>& cases) {
  const test::ScratchFolder folder;
  for (const auto& [name, given] : cases) write(folder / (name + ".given"), given);
  const std::string said = (folder / "said").string();
  const int status =
      std::system(("OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 octave-cli --quiet --no-init-file '" +
                   std::string(STILLFRAME_SOURCE_DIR "/tests/octave/control_package.m") + "' '" +
                   folder.path().string() + "' < /dev/null > '" + said + "' 2>&1")
                      .c_str());
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  Outcome outcome;
  if (code == no_program) {
    outcome.missing = "octave-cli";
  } else if (code == no_package) {
    outcome.missing = "Octave's control package";
  } else if (code != 0) {
    outcome.failure = "octave-cli ended with " + std::to_string(code) + ": " + text_of(said);
  } else {
    for (const auto& [name, given] : cases) {
      outcome.answers[name] = read(folder / (name + ".answer"));
    }
  }
  return outcome;
}

}  // namespace stillframe::octave
