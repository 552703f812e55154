#pragma once

#include <string>
#include <string_view>

namespace stillframe::live {

// What the live page is made of; it needs nothing from elsewhere.
std::string_view live_page();         ///< HTML
std::string_view live_page_script();  ///< JavaScript
std::string_view live_page_style();   ///< CSS
/// What the page may load: its own parts only.
std::string content_security_policy();

}  // namespace stillframe::live
