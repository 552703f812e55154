#include "report/page/tables.hpp"

#include <cmath>
#include <string_view>

#include "core/errors/formatted.hpp"
#include "core/errors/input_error.hpp"
#include "report/page/html.hpp"

namespace stillframe::page {

namespace {

std::string in_scroll(const std::string& table) {
  return element("div", {{"class", "scroll"}, {"tabindex", "0"}}, table);
}

std::string header_row(const std::vector<std::string>& names, const std::vector<bool>& number) {
  std::string cells;
  for (std::size_t i = 0; i < names.size(); ++i) {
    cells += text_element("th", {{"scope", "col"}, {"class", number[i] ? "" : "text"}}, names[i]);
  }
  return element("thead", {}, element("tr", {}, cells));
}

/// A share as it is said: 0.0041, and times where it is more than one.
std::string share(double value, double of) {
  return of > 0 ? number_text(value / of) : number_text(std::nan(""));
}

struct Row {
  const char* name;
  const std::optional<Level>& level;
};

std::string level_cells(const Level& level, const AxisResult& axis, bool is_floor,
                        bool is_passive) {
  std::string cells;
  const auto add = [&](const std::string& text) { cells += text_element("td", {}, text); };
  const auto shares = [&](double Level::*member) {
    add(!is_floor && axis.floor ? share(level.*member, (*axis.floor).*member) : "");
    add(!is_floor && !is_passive && axis.passive ? share(level.*member, (*axis.passive).*member)
                                                 : "");
  };
  add(number_text(1e3 * level.rms_acceleration));
  shares(&Level::rms_acceleration);
  add(number_text(1e3 * level.peak_acceleration));
  add(number_text(1e6 * level.band_velocity));
  shares(&Level::band_velocity);
  add(short_number(level.band_hz));
  return cells + text_element("td", {{"class", "text"}}, level.vibration_class);
}

std::string axis_rows(const AxisResult& axis) {
  const Row rows[] = {{"floor", axis.floor}, {"passive", axis.passive}, {"active", axis.active}};
  std::size_t n_rows = 0, row = 0;
  for (const Row& candidate : rows) n_rows += candidate.level.has_value();
  std::string html;
  for (const auto& [name, level] : rows) {
    if (!level) continue;
    std::string cells;
    if (row == 0) {
      cells = text_element("th", {{"scope", "rowgroup"}, {"rowspan", std::to_string(n_rows)}},
                           axis.axis);
    }
    const std::string key =
        element("span", {{"class", std::string("key ") + name}, {"aria-hidden", "true"}}, "");
    cells += element("th", {{"scope", "row"}, {"class", "text"}}, key + name);
    cells += level_cells(*level, axis, &level == &axis.floor, &level == &axis.passive);
    html += element("tr", {{"class", ++row == n_rows ? "group-end" : ""}}, cells);
  }
  return html;
}

/// A digit at the front, but for signs.
bool looks_like_a_number(std::string_view text) {
  static constexpr std::string_view signs[] = {"+", "-", "<", ">", " ", "\u2212", "\u00b1"};
  if (text.empty() || text == "\u2013") return true;
  for (bool again = true; again;) {
    again = false;
    for (const std::string_view sign : signs) {
      if (!text.starts_with(sign)) continue;
      text.remove_prefix(sign.size());
      again = true;
    }
  }
  return !text.empty() && text.front() >= '0' && text.front() <= '9';
}

/// Which columns hold numbers throughout.
std::vector<bool> number_columns(const Table& table) {
  std::vector<bool> number(table.columns.size(), !table.rows.empty());
  for (const auto& row : table.rows) {
    for (std::size_t i = 0; i < row.size(); ++i) {
      number[i] = number[i] && looks_like_a_number(row[i]);
    }
  }
  if (!number.empty()) number[0] = false;
  return number;
}

}  // namespace

std::string result_table(const std::vector<AxisResult>& axes) {
  std::string body;
  for (const AxisResult& axis : axes) body += axis_rows(axis);
  const std::string head =
      header_row({"axis", "signal", "rms mm/s\u00b2", "of floor", "of passive", "peak mm/s\u00b2",
                  "largest band \u00b5m/s", "of floor", "of passive", "at Hz", "class"},
                 {false, false, true, true, true, true, true, true, true, true, false});
  return in_scroll(element(
      "table", {{"class", "result"}},
      text_element("caption", {},
                   "Acceleration, and the largest one-third-octave band of velocity (rms) with the "
                   "vibration criterion that all bands meet. \u201cOf floor\u201d and \u201cof "
                   "passive\u201d are ratios: the smaller, the quieter.") +
          head + element("tbody", {}, body)));
}

std::string plain_table(const Table& table) {
  const std::vector<bool> number = number_columns(table);
  std::string body;
  for (const auto& row : table.rows) {
    if (row.size() != table.columns.size()) {
      throw InputError("report page: table \"" + table.caption + "\": a row of " +
                       std::to_string(row.size()) + " cells under " +
                       std::to_string(table.columns.size()) + " columns");
    }
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      line += i == 0 ? text_element("th", {{"scope", "row"}, {"class", "text"}}, row[i])
                     : text_element("td", {{"class", number[i] ? "" : "text wrap"}}, row[i]);
    }
    body += element("tr", {}, line);
  }
  return in_scroll(
      element("table", {},
              (table.caption.empty() ? "" : text_element("caption", {}, table.caption)) +
                  header_row(table.columns, number) + element("tbody", {}, body)));
}

std::string matrix_table(const MatrixTable& matrix) {
  const auto n_rows = static_cast<std::size_t>(matrix.values.rows());
  const auto n_columns = static_cast<std::size_t>(matrix.values.cols());
  if (matrix.rows.size() != n_rows || matrix.columns.size() != n_columns) {
    throw InputError("report page: matrix " + matrix.name + " has other sizes than its names");
  }
  double largest = 0;
  for (const double value : matrix.values.reshaped()) {
    if (std::isfinite(value)) largest = std::max(largest, std::abs(value));
  }
  std::vector<std::string> names = matrix.columns;
  names.insert(names.begin(), "");
  std::string body;
  for (std::size_t i = 0; i < n_rows; ++i) {
    std::string line = text_element("th", {{"scope", "row"}}, matrix.rows[i]);
    for (std::size_t j = 0; j < n_columns; ++j) {
      const double value =
          matrix.values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      std::string style;
      if (std::isfinite(value) && largest > 0) {
        style = formatted("--v:%.3f", std::abs(value) / largest);
      }
      // Rounding of an exact zero is shown as zero.
      const bool zero = std::abs(value) < 1e-12 * largest;
      line += text_element("td", {{"style", style}}, zero ? "0" : number_text(value, 4));
    }
    body += element("tr", {}, line);
  }
  const std::string caption = matrix.name + (matrix.unit.empty() ? "" : ", " + matrix.unit);
  return in_scroll(element("table", {{"class", "matrix"}},
                           text_element("caption", {}, caption) +
                               header_row(names, std::vector<bool>(names.size(), true)) +
                               element("tbody", {}, body)));
}

}  // namespace stillframe::page
