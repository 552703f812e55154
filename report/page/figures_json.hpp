#pragma once

#include "report/page/json_text.hpp"
#include "report/page/page_data.hpp"

namespace stillframe::page {

/// What the scripts of the page draw, a key a kind of figure, absent kinds left out; documented in
/// web/README.md. Errors: InputError for sizes that do not fit each other. Set-up.
Json figures_json(const PageData& data);

}  // namespace stillframe::page
