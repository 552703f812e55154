#include "report/live/page_parts.hpp"

namespace stillframe::page {

std::string_view live_script();
std::string_view live_style();
std::string_view live_html();

}  // namespace stillframe::page

namespace stillframe::live {

std::string_view live_page() { return page::live_html(); }
std::string_view live_page_script() { return page::live_script(); }
std::string_view live_page_style() { return page::live_style(); }

// Charts set the style attributes of what they draw.
std::string content_security_policy() {
  return "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; connect-src "
         "'self'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";
}

}  // namespace stillframe::live
