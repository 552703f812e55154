#pragma once

#include <string>
#include <vector>

#include "report/page/page_data.hpp"

namespace stillframe::page {

/// A part of the page with its heading.
struct Section {
  std::string id, heading;
  std::string body;       ///< HTML
  bool one_sheet = true;  ///< kept on one sheet of paper
};

/// Title, verdict, warnings, headlines and facts.
std::string head_html(const PageData& data);

/// Those parts for which there are data, in the order of the page. Figures are empty places that
/// the scripts fill, found by their id. Errors: InputError for tables whose rows do not fit.
std::vector<Section> sections(const PageData& data);

}  // namespace stillframe::page
