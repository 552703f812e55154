#include "report/page/write_page.hpp"

#include <string_view>

#include "core/files/whole_file.hpp"
#include "report/page/figures_json.hpp"
#include "report/page/html.hpp"
#include "report/page/sections.hpp"

namespace stillframe::page {

// Embedded at build time.
std::string_view report_script();
std::string_view report_script_hash();
std::string_view page_style();

namespace {

std::string contents(const std::vector<Section>& parts) {
  std::string links;
  for (const Section& part : parts) {
    links += text_element("a", {{"href", "#" + part.id}}, part.heading);
  }
  return element("nav", {{"class", "contents"}, {"aria-label", "Contents"}}, links);
}

std::string body(const PageData& data) {
  const std::vector<Section> parts = sections(data);
  std::string main;
  for (const Section& part : parts) {
    const std::string id = part.id + "-heading";
    main +=
        element("section",
                {{"id", part.id}, {"class", part.one_sheet ? "keep" : ""}, {"aria-labelledby", id}},
                text_element("h2", {{"id", id}}, part.heading) + part.body);
  }
  return element("header", {{"class", "top"}},
                 head_html(data) + (parts.empty() ? "" : contents(parts))) +
         element("main", {},
                 "<noscript><p>Figures need JavaScript; tables and texts do not.</p></noscript>\n" +
                     main) +
         element("footer", {}, "stillframe " + escape(data.head.program_version));
}

}  // namespace

std::string page_text(const PageData& data) {
  const std::string policy = "default-src 'none'; script-src '" +
                             std::string(report_script_hash()) +
                             "'; style-src 'unsafe-inline'; img-src data: blob:; base-uri 'none'; "
                             "form-action 'none'";
  std::string text = "<!DOCTYPE html>\n<html lang=\"en-GB\">\n<head>\n<meta charset=\"utf-8\">\n";
  text += "<meta http-equiv=\"Content-Security-Policy\" content=\"" + policy + "\">\n";
  text += "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n";
  text += "<link rel=\"icon\" href=\"data:,\">\n";
  text += text_element("title", {}, data.head.title + " \u2013 stillframe report");
  text += "<style>\n" + std::string(page_style()) + "</style>\n</head>\n<body>\n";
  text += body(data);
  text += "<script type=\"application/json\" id=\"stillframe-data\">" +
          script_safe(figures_json(data)) + "</script>\n";
  text += "<script>" + std::string(report_script()) + "</script>\n</body>\n</html>\n";
  return text;
}

void write_page(const PageData& data, const std::filesystem::path& path) {
  write_whole_file(path, page_text(data));
}

}  // namespace stillframe::page
