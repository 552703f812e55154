#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "core/errors/input_error.hpp"

namespace stillframe::tools::spacar {

/// What became of a keyword or a field that is no part of the scene: its line, how it is called
/// there, and why.
struct Remark {
  int line = 0;
  std::string what, why;
};

/// Everything that the scene does not say as the file does, each with its line.
struct Remarks {
  std::vector<Remark> left_out;      ///< changes the model, and is not in the scene
  std::vector<Remark> approximated;  ///< is in the scene, in another form that is not the same
  std::vector<Remark> no_part;       ///< pictures, step sizes, file names: no part of a model
};

inline void sort_by_line(Remarks& remarks) {
  for (std::vector<Remark>* all : {&remarks.left_out, &remarks.approximated, &remarks.no_part}) {
    std::stable_sort(all->begin(), all->end(),
                     [](const Remark& a, const Remark& b) { return a.line < b.line; });
  }
}

/// "FILE:LINE: KEY: found ..., allowed ...", as all bad input is answered.
[[noreturn]] inline void refuse(const std::string& file, int line, const std::string& key,
                                const std::string& found, const std::string& allowed) {
  std::string text = file;
  text += ':';
  text += std::to_string(line);
  text += ": ";
  text += key;
  text += ": found ";
  text += found;
  text += ", allowed ";
  throw InputError(text += allowed);
}

}  // namespace stillframe::tools::spacar
