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

/// Runs gnuplot on a script, with pngcairo set up, and writes its picture as a WholeFile. script:
/// commands after `set terminal`, data inline. Errors: InputError if gnuplot is not installed or
/// stops with an error (its first message is quoted), and those of WholeFile.
void run_gnuplot(const std::string& script, const std::filesystem::path& path);

}  // namespace stillframe::report
