#pragma once

#include <filesystem>

#include "judge/loop_design.hpp"

namespace stillframe::tools {

/// Writes the linear models of a loop for MATLAB, Octave and Python: structures plant, loop (both
/// continuous), open, closed, law, sampled_plant and whole_law (sampled), each with A, B, C, D, Ts
/// and the names and units of its inputs and outputs; the gains K_P and K_I. docs/exports.md says
/// what each is. Errors: InputError if the file cannot be written.
void write_loop_mat(const judge::LoopDesign& design, const std::filesystem::path& file);

}  // namespace stillframe::tools
