#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <string>
#include <vector>

namespace stillframe::report {

/// A number as gnuplot reads it in any locale; NaN for what is not finite.
std::string plot_number(double value);

/// A string literal of gnuplot that stands for exactly this text.
std::string plot_text(const std::string& text);

/// A datablock "$name" of gnuplot, a row a row, columns separated by blanks.
std::string plot_data(const std::string& name, const Eigen::MatrixXd& rows);

/// Runs gnuplot on a script, with pngcairo set up to write `path`. The picture appears under its
/// name only when it is complete, and nothing is left behind if it is not. script: commands after
/// `set terminal` and `set output`, data inline. Errors: InputError if gnuplot is not installed,
/// stops with an error (its first message is quoted), or the folder cannot be written to.
void run_gnuplot(const std::string& script, const std::filesystem::path& path);

}  // namespace stillframe::report
